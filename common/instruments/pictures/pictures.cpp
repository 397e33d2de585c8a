#include "instruments/pictures/pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "instruments/draw/page.hpp"
#include "instruments/measure/run.hpp"

namespace pictures {

std::string figure(double value, int digits) {
  if (value < 0.0 && std::isfinite(value)) return "−" + figure(-value, digits);
  std::string scientific = fmt::format("{:.{}e}", value, digits - 1);
  const std::size_t e = scientific.find('e');
  if (e == std::string::npos) return "too much";  // not finite
  const int exponent = std::stoi(scientific.substr(e + 1));
  if (value == 0.0) return "0";
  if (exponent >= -3 && exponent < 5)
    return fmt::format("{:.{}f}", std::stod(scientific), std::max(0, digits - 1 - exponent));
  static const char* const superscripts[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string power = exponent < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(exponent))) power += superscripts[digit - '0'];
  return scientific.substr(0, e) + "·10" + power;
}

std::string rounded(double value, int decimals) {
  const double size = std::abs(value);
  const bool plain = value == 0.0 || (size >= 0.5 * std::pow(10.0, -decimals) && size < 1e4);
  if (!plain) return figure(value, 3);
  return fmt::format("{}{:.{}f}", value < 0.0 ? "−" : "", size, decimals);
}

namespace {

/// The integrator that a label begins with, as its place among them; those that choose their own
/// steps come after all.
std::optional<std::size_t> integrator_of(const std::string& label) {
  const auto& integrators = integrators::schemes;
  for (std::size_t i = 0; i < integrators.size(); ++i)
    if (label.starts_with(integrators[i].text))
      return label.find("adaptive") != std::string::npos ? integrators.size() : i;
  return {};
}

}  // namespace

// A colour for each integrator, and one for those that choose their own steps.
static_assert(std::tuple_size_v<decltype(draw::Theme::series)> > integrators::schemes.size());

void set_look(draw::Curve& curve, const draw::Theme& theme, const std::string& method,
              std::size_t otherwise) {
  const bool one = method.starts_with(measure::one_coordinate);
  const std::size_t which =
      integrator_of(one ? method.substr(measure::one_coordinate.size()) : method)
          .value_or(otherwise);
  curve.color = theme.series[which % theme.series.size()];
  if (one) curve.color = theme.ink, curve.dash = draw::Dash::dotted;
  curve.marker = which;
  if (method.find("feedback") != std::string::npos) curve.dash = draw::Dash::dotted;
  for (const char* dashed : {"projection", "parametric"})
    if (method.find(dashed) != std::string::npos) curve.dash = draw::Dash::dashed;
}

Picture error_picture(const measure::Report& report) {
  const measure::Quantity& quantity = report.quantities.front();
  draw::Plot plot;
  plot.x = {.label = "processor time [ms]", .log = true};
  plot.y = {.label = fmt::format("error of {} after {:g} s [{}]", quantity.name, report.duration,
                                 quantity.unit),
            .log = true};
  std::vector<std::string> names;
  std::string cheapest;
  double least = 1e300;
  for (const std::string& method : measure::methods(report)) {
    draw::Curve curve;
    curve.label = method;
    curve.markers = true;
    names.push_back(method);
    curve.thickness = method == "rk4" ? 2.6 : 1.6;
    draw::Slope slope;
    std::vector<draw::Point> points;
    for (const measure::Rung& rung : report.rungs) {
      if (rung.method != method) continue;
      if (rung.errors.empty() || rung.errors[0] <= 0.0) {  // a gap in the line
        curve.points.push_back({std::nan(""), std::nan("")});
        continue;
      }
      if (rung.tolerance == 0.0) points.push_back({1e3 * rung.seconds, rung.errors[0]});
      curve.points.push_back({1e3 * rung.seconds, rung.errors[0]});
      slope.order = -rung.order;  // time grows as 1/h
      slope.label = fmt::format("order {}", rung.order);
    }
    // A reference line for every order once, a little below the first curve that has it.
    const bool known = std::any_of(plot.slopes.begin(), plot.slopes.end(),
                                   [&](const draw::Slope& s) { return s.order == slope.order; });
    if (!known && points.size() > 2) {
      const auto [least_error, most_error] = std::minmax_element(
          points.begin(), points.end(), [](auto& a, auto& b) { return a.y < b.y; });
      const double half_way = std::sqrt(least_error->y * most_error->y);
      const draw::Point middle =
          *std::min_element(points.begin(), points.end(), [&](auto& a, auto& b) {
            return std::abs(std::log(a.y / half_way)) < std::abs(std::log(b.y / half_way));
          });
      slope.through = {middle.x, 0.2 * middle.y};
      plot.slopes.push_back(slope);
    }
    plot.curves.push_back(curve);
    const double seconds = measure::time_to_reach(report, method, 1e-6);
    if (seconds < least) {
      least = seconds;
      cheapest = method;
    }
  }
  const std::string price =
      cheapest.empty() ? fmt::format("No method comes below 10⁻⁶ {} to stay.", quantity.unit)
                       : fmt::format("An error of 10⁻⁶ {} costs least with {}: {} ms.",
                                     quantity.unit, cheapest, figure(1e3 * least));
  const std::string caption = price + " " + report.remark;
  return {"error_vs_time", [=, title = report.title + ": error against run time"](draw::Pen& pen) {
            draw::Plot themed = plot;
            for (std::size_t i = 0; i < names.size(); ++i)
              set_look(themed.curves[i], pen.theme(), names[i]);
            draw::draw_plot(pen, draw::page(pen, title, caption), themed);
          }};
}

Drift drift(std::string label, mechanics::Simulation& simulation, double duration, double step) {
  constexpr long windows = 300, least_steps = 8;  // in a window, so that it holds more than zeros
  Drift result;
  result.label = std::move(label);
  simulation.restart();
  const double initial_balance = simulation.measures().balance();
  const long steps = std::lround(duration / step);
  const long window = std::max(std::min(least_steps, std::max(1L, steps / 20)), steps / windows);
  draw::Point constraint_error, energy_error;
  try {
    long done = 0;
    measure::run(simulation, {steps, step}, [&](const mechanics::Measures& now) {
      if (!now.finite()) return false;
      constraint_error = {simulation.time(), std::max(constraint_error.y, now.constraint_error)};
      energy_error = {simulation.time(),
                      std::max(energy_error.y, std::abs(now.balance() - initial_balance))};
      if (++done % window != 0 && done != steps) return true;
      result.constraint_error.push_back(constraint_error);
      result.energy_error.push_back(energy_error);
      result.largest_constraint_error =
          std::max(result.largest_constraint_error, constraint_error.y);
      result.largest_energy_error = std::max(result.largest_energy_error, energy_error.y);
      constraint_error.y = energy_error.y = 0.0;
      return true;
    });
  } catch (const mechanics::Diverged&) {  // the curve ends where the run did
  }
  return result;
}

const Drift& find(const std::vector<Drift>& drifts, std::string_view label) {
  for (const Drift& drift : drifts)
    if (drift.label == label) return drift;
  throw std::out_of_range(std::string(label) + ": no such drift");
}

Picture drift_picture(std::string name, const std::string& title, const std::string& caption,
                      const std::vector<Drift>& drifts, const std::string& constraint_unit) {
  return {std::move(name), [=](draw::Pen& pen) {
            draw::Plot left, right;
            left.title = "off the constraint";
            double duration = 0.0;
            for (const Drift& drift : drifts)
              if (!drift.energy_error.empty())
                duration = std::max(duration, drift.energy_error.back().x);
            left.x =
                right.x = {.label = "time [s]", .min = 0.0, .max = duration > 0.0 ? duration : 1.0};
            left.y = {.label = fmt::format("|C| [{}]", constraint_unit), .log = true};
            right.title = "off the energy balance";
            right.y = {.label = "change of the energy balance [J]", .log = true};
            left.legend = draw::Legend::none;
            right.legend = draw::Legend::none;
            // One legend for both plots, in a row above them.
            const draw::Rect content = draw::page(pen, title, caption);
            double x = content.left, y = content.top + 10.0;
            for (std::size_t i = 0; i < drifts.size(); ++i) {
              const double width = pen.text_width(drifts[i].label) + 58.0;
              if (x + width > content.right() && x > content.left) {
                x = content.left;
                y += 20.0;
              }
              draw::Curve curve{.thickness = 2.0, .markers = true, .mark_every = 50};
              set_look(curve, pen.theme(), drifts[i].label, i);
              for (const draw::Curve& other : left.curves)  // the same method with other gains
                if (*other.marker == *curve.marker && other.dash == curve.dash)
                  curve.marker = *curve.marker + 2;
              draw::draw_sample(pen, {x, y}, curve, *curve.color, *curve.marker);
              pen.text({x + 36.0, y}, drifts[i].label, pen.theme().ink);
              x += width;
              for (draw::Plot* plot : {&left, &right}) plot->curves.push_back(curve);
              left.curves.back().points = drifts[i].constraint_error;
              right.curves.back().points = drifts[i].energy_error;
            }
            const double top = y + 18.0, gap = 24.0, width = 0.5 * (content.width - gap);
            draw::draw_plot(pen, {content.left, top, width, content.bottom() - top}, left);
            draw::draw_plot(pen, {content.left + width + gap, top, width, content.bottom() - top},
                            right);
          }};
}

}  // namespace pictures
