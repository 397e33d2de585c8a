#include "wire.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <limits>
#include <sstream>

namespace any_wire {
namespace {

namespace fs = std::filesystem;
using paths::Path;

constexpr std::size_t most_segments = 10000;  // of a wire

constexpr const char* five_points = "0,0 1,1 2,0.4 3,1.5 4,0.2";

/// The lines of a file as words; words in double quotes are one.
std::vector<std::vector<std::string>> lines_of(const std::string& text) {
  std::vector<std::vector<std::string>> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    std::vector<std::string> words;
    std::istringstream parts(line);
    for (std::string word; parts >> std::quoted(word);) words.push_back(word);
    lines.push_back(words);
  }
  return lines;
}

double number_of(const std::string& option, const std::string& text,
                 const app::Range& allowed = {}) {
  try {
    return app::number(option, text, allowed);
  } catch (const app::UsageError& error) {
    throw std::invalid_argument(error.what());
  }
}

/// Gives a scene one option of a line of a file.
void set(Scene& scene, const std::string& option, const std::string& value) {
  const std::pair<const char*, std::string Scene::*> texts[] = {{"--points", &Scene::points},
                                                                {"--tangents", &Scene::tangents},
                                                                {"--launch", &Scene::launch},
                                                                {"--file", &Scene::file}};
  for (const auto& [name, place] : texts)
    if (option == name) return void(scene.*place = value);
  for (const Number& number : numbers())
    if (option == number.option)
      return void(scene.*number.place = number_of(option, value, number.allowed));
  throw std::invalid_argument(option + ": not an option of a path");
}

/// Where files are read, and how many segments may still come.
struct Reading {
  fs::path folder = {};
  int depth = 0;
  std::size_t& left;
};

Path sequence_of(const Scene& scene, const std::string& text, const Reading& reading);

Path path_of(const Scene& scene, const Reading& reading) {
  const auto points = [&] { return points_of("points", scene.points); };
  const std::string& name = scene.path;
  if (name == "line") {
    const paths::Points p = points();
    paths::check(name, p, 2, 2);
    return paths::line(p[0], p[1]);
  }
  if (name == "circle") return paths::circle(scene.radius);
  if (name == "cycloid") return paths::cycloid(scene.radius);
  if (name == "spiral") return paths::spiral(scene.r0, scene.r1, scene.turns);
  if (name == "sine") return paths::sine(scene.span, scene.amplitude, scene.waves);
  if (name == "quadratic") return paths::quadratic(points());
  if (name == "cubic") return paths::cubic(points());
  if (name == "linear_spline") return paths::linear_spline(points());
  if (name == "cosine_spline") return paths::cosine_spline(points());
  if (name == "hermite_spline")
    return paths::hermite_spline(points(), points_of("tangents", scene.tangents));
  if (name == "catmull_rom") return paths::catmull_rom(points());
  if (name == "projectile") {
    const paths::Points launch = points_of("launch", scene.launch);
    if (launch.size() != 1) throw std::invalid_argument("launch: one velocity, vx,vy");
    return paths::projectile(launch[0], scene.gravity);
  }
  if (scene.is_default_sequence())
    return sequence_of(scene,
                       "0 line --points \"0,0 1,0.6\"\n"
                       "0.3 cubic --points \"1,0.6 2,1.2 2,0 3,0\"\n"
                       "0.7 catmull_rom --points \"3,0 3.5,0.3 4,0.1 4.5,0.8\"\n",
                       reading);
  const fs::path file = reading.folder / scene.file;
  std::ifstream stream(file);
  if (!fs::is_regular_file(file) || !stream)
    throw std::invalid_argument(fmt::format(
        "file {}: cannot be read; allowed is a file with a line for each piece", scene.file));
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  return sequence_of(scene, text, {file.parent_path(), reading.depth, reading.left});
}

Path sequence_of(const Scene& scene, const std::string& text, const Reading& reading) {
  constexpr int deepest = 8;
  const auto refuse = [&](std::size_t line, const std::string& why) {
    throw std::invalid_argument(fmt::format("file {}: line {}: {}", scene.file, line + 1, why));
  };
  if (reading.depth == deepest) refuse(0, fmt::format("files nest deeper than {}", deepest));
  std::vector<paths::Piece> pieces;
  const auto lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::vector<std::string>& words = lines[i];
    if (words.empty()) continue;
    try {
      if (words.size() < 2 || words.size() % 2 != 0)
        throw std::invalid_argument("a piece is its cue, its path, and options with values");
      const auto known = std::find_if(presets().begin(), presets().end(),
                                      [&](const Preset& p) { return p.scene.path == words[1]; });
      if (known == presets().end())
        throw std::invalid_argument(words[1] + " is not the name of a path");
      Scene piece = known->scene;
      piece.gravity = scene.gravity;
      for (std::size_t k = 2; k < words.size(); k += 2) set(piece, words[k], words[k + 1]);
      pieces.push_back({number_of("cue", words[0]),
                        path_of(piece, {reading.folder, reading.depth + 1, reading.left})});
      const std::size_t segments = pieces.back().path.knots.size() + 1;
      if (segments > reading.left)
        throw std::invalid_argument(
            fmt::format("with it there are more than {} segments", most_segments));
      if (piece.path != "sequence" || piece.is_default_sequence()) reading.left -= segments;
    } catch (const std::invalid_argument& error) {
      if (std::string(error.what()).starts_with("file ")) throw;  // of a file inside this one
      refuse(i, error.what());
    }
  }
  return paths::sequence(pieces);
}

}  // namespace

const std::vector<Number>& numbers() {
  constexpr app::Range length{1e-6, 1e6}, radius{0.0, 1e6};
  static const std::vector<Number> numbers{
      {"--radius", "m", "circle, cycloid: radius", &Scene::radius, length},
      {"--r0", "m", "spiral: radius at q = 0", &Scene::r0, radius},
      {"--r1", "m", "spiral: radius at q = 1", &Scene::r1, radius},
      {"--turns", "rad", "spiral: its whole angle", &Scene::turns, {-1e4, 1e4}},
      {"--span", "m", "sine: width", &Scene::span, length},
      {"--amplitude", "m", "sine: amplitude", &Scene::amplitude, {-1e6, 1e6}},
      {"--waves", "", "sine: number of waves", &Scene::waves, {0.0, 1e3}},
  };
  return numbers;
}

const std::vector<Preset>& presets() {
  const auto on = [](const char* path, const char* points, double q0, double speed,
                     double duration) {
    return Preset{{.path = path, .q0 = q0, .speed = speed, .points = points}, duration};
  };
  static const std::vector<Preset> presets = [&] {
    std::vector<Preset> all{
        on("cycloid", "", 3.0, 0.0, 5.0),
        on("line", "0,0 3,2", 0.0, 0.0, 1.0),
        on("circle", "", 2.0, 0.0, 5.0),
        on("spiral", "", 0.0, 1.5, 0.9),
        on("sine", "", 0.0, 4.0, 0.5),
        on("quadratic", "0,0 1.5,3 3,0.5", 0.0, 2.0, 0.7),
        on("cubic", "0,0 1,2 2,-1 3,0.5", 0.0, 2.0, 0.8),
        on("linear_spline", five_points, 0.0, 3.0, 1.0),
        on("cosine_spline", five_points, 0.0, 3.0, 1.0),
        on("hermite_spline", five_points, 0.0, 3.0, 1.0),
        on("catmull_rom", five_points, 0.0, 3.0, 1.0),
        on("projectile", "", 0.0, std::sqrt(13.0), 0.6),
        on("sequence", "", 0.0, 3.0, 1.2),
    };
    for (auto& [scene, duration] : all) {
      scene.tangents = "1,2 2,0 1,0 2,0 1,-3";
      // Where the derivatives of a path jump, its parameter is a poor coordinate.
      if (scene.path.ends_with("spline") || scene.path == "catmull_rom" || scene.path == "sequence")
        scene.by = "length";
    }
    return all;
  }();
  return presets;
}

const Preset& preset(const std::string& path) {
  const auto& all = presets();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Preset& p) { return p.scene.path == path; });
  return found == all.end() ? all.front() : *found;
}

paths::Path path_of(const Scene& scene) {
  try {
    std::size_t left = most_segments;
    const Path path = path_of(scene, {.left = left});
    if (!path(path.first).x.allFinite() || !path(path.last).x.allFinite())
      throw std::invalid_argument("path: it has no finite ends");
    return path;
  } catch (const std::invalid_argument& error) {  // "points: ..." with the value of the option
    const std::string text = error.what(), turns = fmt::format("{:g}", scene.turns);
    for (const auto& [name, value] :
         {std::pair{"points", &scene.points}, std::pair{"tangents", &scene.tangents},
          std::pair{"launch", &scene.launch}, std::pair{"sequence", &scene.file},
          std::pair{"turns", &turns}})
      if (text.starts_with(std::string(name) + ": "))
        throw std::invalid_argument(
            fmt::format("{} {}{}", std::string(name) == "sequence" ? "file" : name,
                        value->empty() ? "''" : *value, text.substr(std::string(name).size())));
    throw;
  }
}

paths::Points points_of(const std::string& option, const std::string& text) {
  paths::Points points;
  std::istringstream stream(text);
  for (std::string pair; stream >> pair;) {
    const std::size_t comma = std::min(pair.find(','), pair.size());
    if (comma == pair.size())
      throw std::invalid_argument(
          fmt::format("{} {}: allowed are pairs of numbers, x,y x,y", option, text));
    points.emplace_back(number_of(option, pair.substr(0, comma)),
                        number_of(option, pair.substr(comma + 1)));
  }
  return points;
}

paths::ByLength wire_of(const Scene& scene) {
  const Path path = path_of(scene);
  try {
    return paths::ByLength(path);
  } catch (const std::invalid_argument& error) {  // "path: ..."
    const bool points = !preset(scene.path).scene.points.empty();
    throw std::invalid_argument(fmt::format("{} {}{}", points ? "points" : "path",
                                            points ? scene.points : scene.path,
                                            std::string(error.what()).substr(4)));
  }
}

Parameter parameter_of(const Path& path) {
  const auto stretch = [&](double q) { return path(q).d.norm(); };
  const double little = 1e-9 * (path.last - path.first);
  std::vector<double> knots = path.knots;
  if (path.closed) knots.push_back(path.last);
  for (const double knot : knots)
    if (const double behind = stretch(knot - little);
        std::abs(stretch(knot + little) - behind) > 1e-3 * behind)
      return Parameter::wrong;
  double least = std::numeric_limits<double>::infinity(), mean = 0.0;
  constexpr int looks = 1000;
  for (int k = 0; k <= looks; ++k) {
    const double here = stretch(path.first + k * (path.last - path.first) / looks);
    least = std::min(least, here);
    mean += here / looks;
  }
  return path.knots.empty() && least > 0.1 * mean ? Parameter::good : Parameter::poor;
}

double fastest(const Scene& scene) {
  const Path path = path_of(scene);
  const double height = path(scene.q0).x.y(), range = path.last - path.first;
  double most = 1e-3;
  const auto look = [&](double q) {
    const auto [x, d, dd] = path(q);
    const double v2 = scene.speed * scene.speed + 2 * scene.gravity * (x.y() - height);
    const double bend =
        scene.by_length() ? std::abs(d.x() * dd.y() - d.y() * dd.x()) / d.norm() : dd.norm();
    const double rate = bend * std::sqrt(std::max(v2, 0.0)) / d.squaredNorm();
    if (std::isfinite(rate)) most = std::max(most, rate);
  };
  std::vector<double> ends = path.knots;
  ends.insert(ends.begin(), path.first);
  ends.push_back(path.last);
  const int looks = std::clamp(20000 / static_cast<int>(ends.size()), 20, 400);
  for (std::size_t i = 1; i < ends.size(); ++i)
    for (int k = 0; k < looks; ++k) look(ends[i - 1] + (k + 0.5) / looks * (ends[i] - ends[i - 1]));
  // Near the start, which may lie beside a place where |x′| is small.
  for (double near = range / looks; near > 1e-9 * range; near /= 2)
    for (const double q : {scene.q0 - near, scene.q0 + near})
      if (path.closed || (q > path.first && q < path.last)) look(q);
  return most;
}

}  // namespace any_wire
