#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "instruments/draw/pen.hpp"

namespace draw {

/// The part of the world that must be visible, in metres; y down, so top < bottom.
struct View {
  double left, top, right, bottom;
};

/// Where the points of the world stand on the page, and the other way round.
struct Lens {
  Rect area;         ///< of the page, in points
  Point center;      ///< of the world, in the middle of the area
  double scale = 1;  ///< points in a metre

  Point to_page(Point world) const { return area.center() + scale * (world - center); }
  Point to_world(Point page) const { return center + 1 / scale * (page - area.center()); }
};

/// A scene in world coordinates (metres, x right, y down) on a rectangle of the page, with the same
/// scale in x and y and `view` in the middle. Nothing is drawn outside the rectangle. The labels of
/// arrows come last, where they cover least.
class Canvas {
 public:
  /// Throws std::invalid_argument when the view is empty or not finite.
  Canvas(Pen& pen, const Rect& area, const View& view);
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;
  ~Canvas();

  /// A frame with round numbers along the bottom and the left; `unit` of both axes, such as "m".
  /// Makes room for its numbers and so changes to_page: to be called before anything is drawn,
  /// else throws std::logic_error.
  void axes(std::string_view unit);

  Lens lens() const;
  Point to_page(double x, double y) const { return lens().to_page({x, y}); }
  double points_per_metre() const { return scale_; }
  const Theme& theme() const { return pen_.theme(); }

  void curve(std::span<const Point> points, Color color, double thickness_points = 1.6,
             Dash dash = Dash::solid);
  void disc(Point center, double radius, Color fill, Color edge);
  void bead(Point center, double radius_points, Color fill, Color edge);
  /// `angle` in radians, from +x towards +y (clockwise on the page).
  void box(Point center, double width, double height, double angle, Color fill, Color edge);
  /// A rod with rounded ends.
  void link(Point a, Point b, double width_points, Color fill, Color edge);
  /// From `from` to `from` + `vector`, both in metres. The label stands near the head.
  void arrow(Point from, Point vector, Color color, std::string_view label = "");
  /// An arc about `center` from one angle to another [rad, from +x towards +y], with a head at its
  /// end: a moment, an angle. The label stands beyond the middle of it.
  void turn(Point center, double radius_points, double from, double to, Color color,
            std::string_view label = "");
  /// `at` in metres, moved by `offset_points` on the page; kept inside the canvas.
  void label(Point at, std::string_view text, Color color, Font font = Font::text,
             Align align = Align::left, Point offset_points = {});
  /// A revolute joint.
  void pin(Point at);
  /// The two points that a joint should hold together, where they are visibly apart: a mark on each
  /// and a line between them. Where they are not, nothing.
  void gap(Point a, Point b);
  /// A fixed surface below `at`, hatched; turned by `angle` radians.
  void ground(Point at, double angle = 0, double width_points = 40);
  /// At the bottom right a round number of newtons, as long as their arrow.
  void force_scale(double metres_per_newton);
  /// A small cross of axes: x to the right, y down.
  void origin(Point at);

 private:
  Point page(Point world);
  void fit(const Rect& area);
  void text(Point at, std::string_view text, Color color, Font font, Align align);

  using Segment = std::array<Point, 2>;  // of the page
  struct ArrowLabel {
    Segment arrow;
    std::string text;
    Color color;
  };
  void place(const ArrowLabel& label);
  /// How much a text there would hide.
  double cover(const Rect& text) const;

  Pen& pen_;
  View view_;
  Rect outer_, area_;  ///< all of it; what is left of it for the scene
  double scale_ = 1;
  bool drawn_ = false;
  std::vector<ArrowLabel> labels_;
  std::vector<Segment> arrows_;
  std::vector<Rect> texts_, beads_;
};

}  // namespace draw
