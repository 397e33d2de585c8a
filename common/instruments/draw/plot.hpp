#pragma once

#include <optional>
#include <string>
#include <vector>

#include "instruments/draw/pen.hpp"

namespace draw {

struct Axis {
  std::string label = {};  ///< with its unit, as in "time [s]"
  bool log = false;
  std::optional<double> min = {}, max = {};  ///< found from the points where not set
};

/// On a logarithmic axis values that are not positive, on any axis those that are not finite, are
/// left out and break the line.
struct Curve {
  std::string label = {};  ///< no entry in the legend when empty
  std::vector<Point> points = {};
  std::optional<Color> color = {};  ///< the theme's next series colour when not set
  Dash dash = Dash::solid;
  double thickness = 1.8;
  bool markers = false;
  std::size_t mark_every = 1;              ///< of the points, from the one in the middle of them
  std::optional<std::size_t> marker = {};  ///< one of six shapes; by its place when not set
  double marker_size = 1.0;                ///< relative to the usual one
  bool line = true;
};

/// The line y ∝ xᵒʳᵈᵉʳ through a point, drawn thin; for two logarithmic axes.
struct Slope {
  double order = 1;
  std::string label = {};
  Point through = {};
};

/// A rectangle between two points of the plane, below the curves.
struct Tile {
  Point low, high;
  Color fill;
};

/// `automatic`: in a corner where it covers no curve, or above the plot when there is none.
enum class Legend { automatic, top_left, top_right, bottom_left, bottom_right, above, none };

struct Plot {
  std::string title = {};
  Axis x = {}, y = {};
  std::vector<Curve> curves = {};
  std::vector<Slope> slopes = {};
  std::vector<Tile> tiles = {};
  Legend legend = Legend::automatic;
};

/// What stands before a curve's name in a legend: a piece of its line, with its marker, from
/// `left`.
void draw_sample(Pen& pen, Point left, const Curve& curve, Color color, std::size_t marker);

/// Throws std::invalid_argument for min >= max, for a limit that is not finite or, on a logarithmic
/// axis, not positive, and for a slope without two logarithmic axes.
void draw_plot(Pen& pen, const Rect& area, const Plot& plot);

}  // namespace draw
