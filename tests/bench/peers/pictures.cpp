#include "pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "instruments/draw/page.hpp"

namespace peers {
namespace {

using draw::Point;

/// Colours by rank; beyond the theme's, grey and dashed.
void style(draw::Curve& curve, std::size_t rank, const draw::Theme& theme) {
  curve.marker = rank + rank / theme.series.size();
  const bool spare = rank >= theme.series.size();
  curve.color = spare ? theme.muted : theme.series[rank];
  if (spare) curve.dash = draw::Dash::dashed;
  curve.thickness = curve.label == ours ? 2.8 : 1.8;
  curve.markers = true;
}

/// The runs that no cheaper run of the engine betters: (time [ms], error [rad]).
std::vector<Point> frontier(const std::vector<Row>& rows, const std::string& engine) {
  std::vector<Point> points, front;
  for (const Row& row : rows)
    if (row.engine == engine && row.failure.empty() && row.error)
      points.push_back({1e3 * row.seconds, std::max(lasting_error(rows, row), 1e-17)});
  std::sort(points.begin(), points.end(), [](Point a, Point b) { return a.x < b.x; });
  for (const Point point : points)
    if (front.empty() || point.y < front.back().y) front.push_back(point);
  return front;
}

}  // namespace

pictures::Picture slider_crank_picture(const Report& report) {
  const std::vector<Row>& rows = report.slider_crank;
  const std::string caption =
      "Large marks: each engine as it comes. A curve joins the runs that no cheaper run of the "
      "engine betters; an error counts where those of finer steps are no larger.";
  return {"slider_crank", [=](draw::Pen& pen) {
            draw::Plot plot;
            plot.x = {.label = "processor time of 2 s [ms]", .log = true};
            plot.y = {.label = "error of the wheel's angle [rad]", .log = true};
            std::vector<draw::Curve> defaults;
            for (const std::string& name : names(rows)) {
              draw::Curve curve{.label = name, .points = frontier(rows, name)};
              style(curve, plot.curves.size(), pen.theme());
              plot.curves.push_back(curve);
              curve.label.clear();
              curve.points.clear();
              curve.line = false;
              curve.marker_size = 2.0;
              for (const Row& row : rows)
                if (row.engine == name && row.is_default && row.failure.empty() && row.error)
                  curve.points.push_back({1e3 * row.seconds, *row.error});
              defaults.push_back(curve);
            }
            plot.curves.insert(plot.curves.end(), defaults.begin(), defaults.end());
            draw::draw_plot(pen, draw::page(pen, "The slider-crank in other engines", caption),
                            plot);
          }};
}

pictures::Picture purpose_picture(const Report& report) {
  // By what the makers say of them.
  static const std::map<std::string, std::string> purposes{
      {ours, "this solver: mechanisms in the plane, exact motion"},
      {dense_form, "dense matrices: the equation as it is written"},
      {"Box2D", "Box2D: games, many bodies that touch"},
      {"Chipmunk", "Chipmunk: games, many bodies that touch"},
      {"MuJoCo", "MuJoCo: robots, contact, control"},
      {"Simbody", "Simbody: joints in space, bones and muscles"},
      {"SUNDIALS IDA", "SUNDIALS IDA: any equation with constraints"}};
  const std::string caption =
      "The slider-crank for 2 s, each engine with the settings it comes with. Engines for games "
      "take any step and look right; those for machines take the steps that they need.";
  return {"purpose", [=](draw::Pen& pen) {
            draw::Plot plot;
            plot.x = {.label = "processor time of 2 s [ms]", .log = true};
            plot.y = {.label = "error of the wheel's angle [rad]", .log = true};
            plot.legend = draw::Legend::above;
            for (const std::string& name : names(report.slider_crank)) {
              const Row* row = default_run(report.slider_crank, name, 3);
              if (row == nullptr || !row->error) continue;
              draw::Curve curve{.label = purposes.at(name),
                                .points = {{1e3 * row->seconds, *row->error}}};
              style(curve, plot.curves.size(), pen.theme());
              curve.line = false;
              curve.marker_size = 2.0;
              plot.curves.push_back(curve);
            }
            draw::draw_plot(pen, draw::page(pen, "What each engine is for", caption), plot);
          }};
}

pictures::Picture chain_picture(const Report& report) {
  const std::vector<Row>& rows = report.chain;
  const std::string caption =
      "Of all settings tried the cheapest. What these steps are worth is in the table: the error "
      "of "
      "one is not that of another.";
  return {"chain", [=](draw::Pen& pen) {
            draw::Plot plot;
            plot.x = {.label = "links N", .log = true};
            plot.y = {.label = "processor time of a step [µs]", .log = true};
            std::size_t rank = 0;
            for (const std::string& name : names(rows)) {
              draw::Curve curve{.label = name};
              for (const int links : {1, 10, 100, 1000})
                if (const double seconds = step_seconds(rows, name, links); std::isfinite(seconds))
                  curve.points.push_back({double(links), 1e6 * seconds});
              style(curve, rank++, pen.theme());
              plot.curves.push_back(curve);
            }
            draw::draw_plot(pen, draw::page(pen, "What a step of a chain costs", caption), plot);
          }};
}

}  // namespace peers
