#pragma once

#include <string>
#include <vector>

namespace any_wire {

/// A bead on a wire that is any path, and what it is described by. The options of paths other than
/// the chosen one stand idle.
struct Scene {
  std::string path = "cycloid";
  std::string by = "parameter";        ///< or "length"
  double q0 = 3.0;                     ///< start
  double speed = 0.0;                  ///< along growing q [m/s]
  double mass = 1.0;                   ///< [kg]
  double gravity = 9.81;               ///< [m/s²], along +y: down
  double radius = 1.0;                 ///< circle, cycloid [m]
  double r0 = 1.0, r1 = 0.2;           ///< spiral [m]
  double turns = 4.0;                  ///< spiral: its whole angle [rad]
  double span = 3.0, amplitude = 0.3;  ///< sine [m]
  double waves = 3.0;                  ///< sine
  std::string points = {};             ///< "x,y x,y" [m]
  std::string tangents = {};           ///< of a Hermite spline, the same
  std::string launch = "2,-3";         ///< projectile, "vx,vy" [m/s]
  std::string file = {};               ///< sequence; empty: one of the chapter's own

  bool by_length() const { return by == "length"; }
  bool is_default_sequence() const { return path == "sequence" && file.empty(); }
};

/// A scene of a path and the time [s] that it is shown for.
struct Preset {
  Scene scene;
  double duration;
};

/// Of every path, in the order of the lesson's table.
const std::vector<Preset>& presets();
/// The one whose path has that name, or the first.
const Preset& preset(const std::string& path);

}  // namespace any_wire
