#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "instruments/draw/offscreen.hpp"
#include "instruments/draw/pen.hpp"
#include "instruments/draw/plot.hpp"
#include "instruments/measure/report.hpp"
#include "mechanics/motion/motion.hpp"

namespace pictures {

/// A picture: its file name without ending, and what draws it. Everything is computed beforehand,
/// so that drawing it again in another size or theme costs nothing.
struct Picture {
  std::string name;
  std::function<void(draw::Pen&)> draw;
};

/// A number for a caption, in as many significant digits: "0.0064", "210", "7·10⁻⁶".
std::string figure(double value, int digits = 2);

/// A number for a label, in hundredths (or other decimals) where they are few digits and not all
/// zeros, else as a figure of three digits: "9.81", "2.26·10¹⁵".
std::string rounded(double value, int decimals = 2);

/// Error of the first quantity against processor time, a curve a method, with lines of the
/// theoretical orders through each method's own points.
Picture error_picture(const measure::Report& report);

/// A method looks alike in all plots: the colour and the marker are its integrator's, the dash its
/// stabilization's, or that of chapter 2's description. A name that begins with no integrator takes
/// the colour and marker `otherwise`.
void set_look(draw::Curve& curve, const draw::Theme& theme, const std::string& method,
              std::size_t otherwise = 0);

/// How far one run strays, over time. The times are cut into windows and each point is the largest
/// value in its window, so that the zeros that an error swings through do not tear a logarithmic
/// curve.
struct Drift {
  std::string label;
  std::vector<draw::Point> constraint_error;  ///< (s, |C|)
  std::vector<draw::Point> energy_error;      ///< (s, |E − E(0)| in J)
  double largest_constraint_error = 0.0, largest_energy_error = 0.0;
};

/// Runs the simulation from its start and watches every step. A run that diverges ends its curves
/// there.
Drift drift(std::string label, mechanics::Simulation& simulation, double duration, double step);

/// That of a label; std::out_of_range where there is none.
const Drift& find(const std::vector<Drift>& drifts, std::string_view label);

/// One curve of each drift in two plots side by side: |C| and energy error, both logarithmic.
Picture drift_picture(std::string name, const std::string& title, const std::string& caption,
                      const std::vector<Drift>& drifts, const std::string& constraint_unit);

}  // namespace pictures
