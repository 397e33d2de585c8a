#pragma once

#include "instruments/pictures/lesson.hpp"
#include "mechanism.hpp"

// How the machine is drawn, here and in later chapters.

namespace slider_crank {

using namespace pictures::lesson;

/// The forces on the bodies that the joints are named after, each at the place where it acts.
struct Forces {
  Vector2d wheel_frame, rod_wheel, slider_rod, slider_frame;
};

/// Where a body is.
struct Pose {
  Vector2d x = Vector2d::Zero();
  double angle = 0.0;

  /// The point u of the body's own frame.
  Vector2d at(const Vector2d& u) const { return x + dynamics::rotation(angle) * u; }
};

struct Instant {
  double t;
  Pose frame, wheel, rod, slider;
  Vector2d crank_pin, rod_start, rod_end;  ///< of the wheel, and of the rod
  Forces forces;
};

/// Of a motion with the joints that `bodies` came with.
Instant now(const Scene& scene, mechanics::Motion<mechanics::Mechanism>& motion,
            const Bodies& bodies);

draw::View view(const Scene& scene);
void draw_frame(Canvas& canvas, const Scene& scene, const Pose& frame);
/// The moving bodies; `muted` leaves the colours to the arrows that come on top.
void draw_bodies(Canvas& canvas, const Scene& scene, const Instant& at, double presence,
                 bool muted);
void draw_mechanism(Canvas& canvas, const Scene& scene, const Instant& at, bool muted = false);
/// Arrows of the four joint reactions, `metres` long where the force is `newtons`.
void draw_forces(Canvas& canvas, const Instant& at, double newtons, double metres,
                 bool labelled = true);
double largest(const Forces& forces);

}  // namespace slider_crank
