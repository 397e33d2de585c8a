#include "inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "random.hpp"

namespace fuzz {
namespace {

using Words = std::vector<std::string>;

/// The parts of a text between its bars.
Words split(const std::string& text, char bar = '|') {
  Words words(1);
  for (const char c : text)
    if (c == bar)
      words.emplace_back();
    else
      words.back() += c;
  return words;
}

const Words no_numbers = split(
    "nan|-nan|NaN|nan(1)|inf|-inf|Infinity|1e400|-1e400|1e308|-1.7976931348623157e308|1e-400|"
    "4.9e-324|-2e-310|1e-13|1.0000001e12|0x10|0x1p4|| | 1|1 |1e|1e-|1e+|.|-|--|+|+-1|++1|,|1,5|1,|"
    "1.2.3|1'000|1_000|one|½|−1|٣|🙂|\xff\xfe|\xc3|\x01|\t\n|1\n|a\nwarning: "
    "b|\x1b[31m|{}|{:g}|"
    "%s%n|$(x)|'\"\\|--step|--x0=1|run|-h5");
const Words edge_numbers =
    split("0|-0|0.0|1|-1|1e-12|1e12|-1e12|1e-6|1e6|90|-90|100|+2|1e-300|5.|.5|1E3|2|1000|007|-.5");
const Words unwritable =
    split("/dev/full|/dev/null/run.csv|/proc/none/run.csv|none/run.csv|/|.|..|/proc|run.csv/");

std::string shown(double value, Random& random) {
  const std::size_t form = random.below(3);
  return form == 0   ? fmt::format("{:.3g}", value)
         : form == 1 ? fmt::format("{:.17e}", value)
                     : fmt::format("{}", value);
}

std::string nonsense(Random& random) {
  if (random.chance(0.1))
    return std::string(1 + random.below(3000), random.chance(0.5) ? '9' : '-');
  if (random.chance(0.1)) {
    std::string bytes;
    for (std::size_t n = random.below(12); n > 0; --n)
      bytes += static_cast<char>(1 + random.below(255));
    std::replace(bytes.begin(), bytes.end(), '/', '_');  // it may end as a file's name
    return bytes;
  }
  return random.pick(no_numbers);
}

/// A value for a number, `wildness` from 0 (what a reader would try) to 2 (any that there is).
std::string value(const Option& option, int wildness, Random& random) {
  if (!option.choices.empty() && !random.chance(0.05)) return random.pick(option.choices);
  const double preset = option.preset.value_or(1.0);
  if (random.chance(0.01 + 0.01 * wildness)) return nonsense(random);
  if (random.chance(0.03 + 0.03 * wildness)) return random.pick(edge_numbers);
  const double sign = random.chance(0.05) ? -1.0 : 1.0;
  if (wildness > 0 && random.chance(0.8)) {
    const double size = random.scale(wildness > 1 ? -12.0 : -3.0, wildness > 1 ? 12.0 : 3.0);
    return shown(sign * (random.chance(0.2) ? std::round(size) : size), random);
  }
  if (random.chance(0.3)) return shown(static_cast<double>(random.below(7)), random);
  const double near = (preset != 0.0 ? preset : 1.0) * random.scale(-0.7, 0.7);
  return shown(sign * (preset == 1.0 && random.chance(0.5) ? std::ceil(near) : near), random);
}

class Maker {
 public:
  Maker(Random& random, const std::vector<Option>& options) : random_(random), options_(options) {}

  Input run() {
    arguments_ = {"run"};
    const int wildness = random_.chance(0.4) ? 0 : random_.chance(0.5) ? 1 : 2;
    double rods = 1.0;  // a mechanism of a thousand bodies takes as long as a thousand
    const auto scene = std::count_if(options_.begin(), options_.end(),
                                     [](const Option& option) { return option.group == "Scene"; });
    for (const Option& option : options_)
      if (option.group == "Scene" && random_.chance(2.0 / static_cast<double>(scene))) {
        const std::string text = value(option, wildness, random_);
        if (option.name == "--links") rods = std::max(1.0, std::strtod(text.c_str(), nullptr));
        give(option.name, text);
      }
    times(wildness, rods);
    method(wildness, rods);
    output();
    if (random_.chance(0.05)) spoil();
    return {arguments_};
  }

  /// Another command, or none, with something in it that must be refused: what else it does is no
  /// matter for a fuzzer, since pictures and measurements take their time.
  Input refused() {
    static const Words commands = split(
        "snapshot|report|stability|snapshot|report|stability|run||fly|--|Run|ru|\xff|-x|run run");
    static const Words bad = split(
        "--fly|--fly=1|--integrator rk5|--stabilization=|--step 0|--step nan|--duration -1|"
        "--gravity inf|--ks -1|--kd|--tolerance 1|--tolerance 1e-8 --integrator rk4|fly|-- 1|"
        "--size 1x1|--scale nan|--at ,|--theme pink|--out|--out /dev/null/x --at x|--frames 0|"
        "--frames 1.5|--fps 10|--frames 2 --fps 0|--sheet 0x3|--sheet 4|--sheet 2x2 --frames 2|"
        "--frames 2 --at 1|--sheet 1x1 --at 0,1");
    arguments_ = {random_.pick(commands)};
    if (random_.chance(0.1)) arguments_.clear();
    for (const Option& option : options_)
      if (option.group == "Scene" && random_.chance(0.2))
        give(option.name, fmt::format("{}", option.preset.value_or(1.0)));
    for (const std::string& word : split(random_.pick(bad), ' ')) arguments_.push_back(word);
    return {arguments_, true};
  }

  /// Small pictures of any scene, soon after its start.
  Input pictures() {
    static const Words which = split("--at 0.1|--at 0,0.05|--frames 3 --fps 30|--sheet 2x2");
    arguments_ = {"snapshot", "--size", "480x300", "--scale", "0.5", "--duration", "0.1"};
    for (const Option& option : options_)
      if (option.group == "Scene" && random_.chance(0.3))
        give(option.name, value(option, 0, random_));
    for (const std::string& word : split(random_.pick(which), ' ')) arguments_.push_back(word);
    return {arguments_};
  }

  Input harmless() {
    if (random_.chance(0.5)) return pictures();
    static const Words helps = split("--help|run --help|snapshot -h|report --help|run -h5");
    return {split(random_.pick(helps), ' ')};
  }

 private:
  void give(const std::string& name, const std::string& text) {
    if (random_.chance(0.2)) {
      arguments_.push_back(name + "=" + text);
    } else {
      arguments_.push_back(name);
      arguments_.push_back(text);
    }
  }

  /// At most some 200 steps, unless the two are so far apart that they must be refused.
  void times(int wildness, double rods) {
    const double reach = wildness == 0 ? 1.0 : random_.chance(0.7) ? 3.0 : 12.0;
    double duration = random_.scale(-reach, reach);
    const double most = std::max(1.0, 200.0 / rods);
    double step = duration / (random_.chance(0.3) ? 1.0 + std::floor(most * random_.unit())
                                                  : random_.between(0.5, most));
    if (random_.chance(0.02)) duration = 1e12, step = random_.scale(-12.0, 3.0);
    const auto text = [&](double number) {
      return random_.chance(0.005) ? random_.pick(no_numbers) : fmt::format("{}", number);
    };
    give("--duration", text(duration));
    give("--step", text(step));
    step_ = step;
    duration_ = duration;
  }

  void method(int wildness, double rods) {
    std::string integrator;
    for (const Option& option : options_) {
      if (option.group != "Method" || option.name == "--duration" || option.name == "--step")
        continue;
      if (!option.choices.empty()) {
        const std::string name =
            random_.chance(0.02) ? nonsense(random_) : random_.pick(option.choices);
        // Its equation is dense, and with a thousand rods takes minutes by right.
        const bool slow = name == "implicit_midpoint" && rods > 50.0;
        if (!random_.chance(0.6) || slow) continue;
        if (option.name == "--integrator") integrator = name;
        give(option.name, name);
      } else if (option.name == "--tolerance") {
        // How many steps it takes is its own choice: few enough in a usual scene for a short time.
        const bool few = wildness == 0 && duration_ < 10.0;
        if (random_.chance(integrator != "dop853" ? 0.02 : few ? 0.5 : 0.0))
          give(option.name, fmt::format("{:.2g}", random_.scale(-14.5, -0.8)));
      } else if (random_.chance(0.12)) {
        give(option.name, value(option, wildness, random_));
      }
    }
  }

  void output() {
    if (random_.chance(0.2)) give("--every", fmt::format("{}", step_ * random_.scale(-0.1, 2.0)));
    if (!random_.chance(0.5)) return;
    if (random_.chance(0.8))
      give("--csv", random_.chance(0.5) ? "-" : "run.csv");
    else
      give("--csv", random_.chance(0.6) ? random_.pick(unwritable) : nonsense(random_));
  }

  /// Something too many, twice or missing. Nothing that lets a number fall back to its default,
  /// for then there could be very many steps.
  void spoil() {
    const auto anywhere = [&] {
      return arguments_.begin() + static_cast<std::ptrdiff_t>(random_.below(arguments_.size() + 1));
    };
    switch (random_.below(6)) {
      case 0:
        arguments_.insert(anywhere(), nonsense(random_));
        break;
      case 1:
        arguments_.insert(anywhere(), "--");
        break;
      case 2:
        arguments_.insert(anywhere(), random_.pick(Words{"--fly", "-x", "--x0x=1"}));
        break;
      case 3:
        give(random_.pick(options_).name, "1");
        break;  // most likely twice
      case 4:
        arguments_.push_back(random_.pick(options_).name);
        break;
      default:
        arguments_.push_back("--" + nonsense(random_));
    }
  }

  Random& random_;
  const std::vector<Option>& options_;
  Words arguments_;
  double step_ = 1.0, duration_ = 1.0;
};

}  // namespace

std::vector<Option> read_help(const std::string& help) {
  std::vector<Option> options;
  std::istringstream stream(help);
  std::string group;
  for (std::string line; std::getline(stream, line);) {
    if (line.ends_with(':') && !line.starts_with(' ')) group = line.substr(0, line.size() - 1);
    std::istringstream words(line);
    Option option;
    words >> option.name;
    if (!option.name.starts_with("--")) continue;
    option.group = group;
    const std::string preset = "(default ";
    if (const std::size_t at = line.find(preset); at != std::string::npos) {
      double number = 0.0;
      const char* last = line.data() + line.size();
      const auto [end, error] = std::from_chars(line.data() + at + preset.size(), last, number);
      if (error == std::errc{} && end != last && *end == ')') option.preset = number;
    }
    std::string word;
    if (words >> word && word == "NAME")
      for (bool more = true; more && words >> word;) {
        more = word.ends_with(',');
        option.choices.push_back(word.substr(0, word.find_first_of(",:")));
      }
    options.push_back(option);
  }
  return options;
}

Input make_input(std::uint64_t seed, std::uint64_t index, const std::vector<Option>& options) {
  Random random(seed, index);
  Maker maker(random, options);
  if (random.chance(0.01)) return maker.refused();
  if (random.chance(0.002)) return maker.harmless();
  return maker.run();
}

std::size_t choose(std::uint64_t seed, std::uint64_t index, std::size_t count) {
  return Random(~seed, index).below(count);
}

std::string quoted(const std::string& argument) {
  const auto plain = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
           std::string_view("+-=._,/:").find(c) != std::string_view::npos;
  };
  if (!argument.empty() && std::all_of(argument.begin(), argument.end(), plain)) return argument;
  std::string text = "$'";
  for (const char c : argument)
    if (plain(c) || c == ' ')
      text += c;
    else  // three octal digits end by themselves
      text += fmt::format("\\{:03o}", static_cast<unsigned char>(c));
  return text + "'";
}

}  // namespace fuzz
