#include "instruments/draw/ticks.hpp"

#include <array>
#include <cstdio>
#include <utility>

namespace draw {
namespace {

std::string with_minus(std::string number) {
  if (number.starts_with('-')) number.replace(0, 1, "−");
  return number;
}

std::string fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return with_minus(text);
}

std::string power_of_ten(int exponent) {
  static constexpr std::array digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent))) {
    text += digits[static_cast<std::size_t>(digit - '0')];
  }
  return text;
}

// The exponent of the leading digit; the small addend forgives the rounding of 10^n.
int magnitude(double value) { return static_cast<int>(std::floor(std::log10(value) + 1e-9)); }

}  // namespace

std::vector<Tick> linear_ticks(double low, double high, int at_most) {
  const double finest = (high - low) / (at_most + 1);
  // So narrow a range has no round numbers that a double can tell apart.
  if (!(finest > 1e-12 * std::max(std::abs(low), std::abs(high))) || !std::isfinite(finest)) {
    return {};
  }
  double step = 0, first = 0, last = 0;
  for (double decade = std::pow(10, magnitude(finest)); step == 0; decade *= 10) {
    for (const double multiple : {1, 2, 5}) {
      first = std::ceil(low / (multiple * decade) - 1e-6);
      last = std::floor(high / (multiple * decade) + 1e-6);
      if (last - first >= at_most) continue;
      step = multiple * decade;
      break;
    }
  }
  const double largest = std::max(std::abs(first), std::abs(last)) * step;
  const int top = largest > 0 ? magnitude(largest) : 0;
  const bool scientific = top >= 5 || top < -3;
  const int decimals = std::clamp((scientific ? top : 0) - magnitude(step), 0, 15);
  std::vector<Tick> ticks;
  for (double i = first; i <= last; ++i) {
    const double value = i * step;
    if (i == 0) {
      ticks.push_back({0, "0"});
    } else if (scientific) {
      ticks.push_back(
          {value, fixed(value / std::pow(10, top), decimals) + "×" + power_of_ten(top)});
    } else {
      ticks.push_back({value, fixed(value, decimals)});
    }
  }
  return ticks;
}

std::vector<Tick> log_ticks(double low, double high, int at_most) {
  const int first = static_cast<int>(std::ceil(std::log10(low) - 1e-9));
  const int last = static_cast<int>(std::floor(std::log10(high) + 1e-9));
  std::vector<Tick> ticks;
  if (last - first < 1) {
    const bool plain = first > -3 && last < 4;
    int labels = 0;
    for (int exponent = first - 1; exponent <= last; ++exponent) {
      for (int multiple = 1; multiple <= 9; ++multiple) {
        const double value = multiple * std::pow(10, exponent);
        if (value < low * (1 - 1e-9) || value > high * (1 + 1e-9)) continue;
        ticks.push_back({value, ""});
        if (multiple != 1 && multiple != 2 && multiple != 5) continue;
        ++labels;
        const std::string factor = multiple == 1 ? "" : std::to_string(multiple) + "×";
        ticks.back().label =
            plain ? fixed(value, std::max(-exponent, 0)) : factor + power_of_ten(exponent);
      }
    }
    return labels < 2 || labels > at_most ? linear_ticks(low, high, at_most) : ticks;
  }
  int stride = 1;
  for (const int longer : {2, 3, 5, 10, 20, 50, 100, 200}) {
    if (last / stride - (first - 1) / stride <= at_most) break;
    stride = longer;
  }
  for (int exponent = first - 1; exponent <= last; ++exponent) {
    const double decade = std::pow(10, exponent);
    const bool label = exponent % stride == 0;
    // More than four marks between two labels would run together.
    if (exponent >= first && (label || stride <= 5)) {
      ticks.push_back({decade, label ? power_of_ten(exponent) : ""});
    }
    for (int multiple = 2; stride == 1 && multiple <= 9; ++multiple) {
      const double value = multiple * decade;
      if (value > low && value < high) ticks.push_back({value, ""});
    }
  }
  return ticks;
}

std::vector<Tick> fitting_ticks(const Pen& pen, double low, double high, bool log, double extent,
                                bool horizontal) {
  const auto map = [log](double value) { return log ? std::log10(value) : value; };
  const auto fits = [&](const std::vector<Tick>& ticks) {
    double free_from = -1e300;
    for (const Tick& tick : ticks) {
      if (tick.label.empty()) continue;
      const double at = extent * (map(tick.value) - map(low)) / (map(high) - map(low));
      const double half = horizontal ? pen.text_width(tick.label, Font::small) / 2 + 7
                                     : Pen::line_height(Font::small) * 0.75;
      if (at - half < free_from) return false;
      free_from = at + half;
    }
    return true;
  };
  const double spacing = horizontal ? 60 : 36;
  std::vector<Tick> ticks;
  for (int n = std::clamp(static_cast<int>(extent / spacing), 4, log ? 24 : 12); n >= 2; --n) {
    ticks = log ? log_ticks(low, high, n) : linear_ticks(low, high, n);
    if (fits(ticks)) return ticks;
  }
  // Not even two labels fit beside each other.
  std::erase_if(ticks, [](const Tick& tick) { return tick.label.empty(); });
  if (ticks.size() > 1) ticks.resize(1);
  return ticks;
}

}  // namespace draw
