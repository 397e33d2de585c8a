#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "mechanics/integrators/no_step.hpp"

namespace integrators {

/// The coefficients of Dormand and Prince's method 8(5,3) as Hairer, Nørsett and Wanner publish
/// them (Solving Ordinary Differential Equations I, 2nd edition, Springer 1993, code DOP853).
namespace dop853 {

inline constexpr std::size_t stages = 12;

/// Where in the step each stage stands.
inline constexpr std::array<double, stages> c{0.0,
                                              0.052600151958767731879,
                                              0.078900227938151597818,
                                              0.11835034190722739673,
                                              0.28164965809277260327,
                                              0.33333333333333333333,
                                              0.25,
                                              0.30769230769230769231,
                                              0.65128205128205128205,
                                              0.6,
                                              0.85714285714285714286,
                                              1.0};

/// The weights of the rates of all earlier stages: in each later stage, in the step, and in the two
/// estimates of its error, differences to formulas of orders 3 and 5.
inline constexpr std::size_t whole_step = 12, error_3 = 13, error_5 = 14;
inline constexpr std::array<std::array<double, stages>, 15> weights{{
    {{}},                                                       // stage 1 is the state itself
    {{0.052600151958767731879}},                                // stage 2
    {{0.019725056984537899454, 0.059175170953613698363}},       // stage 3
    {{0.029587585476806849182, 0.0, 0.088762756430420547545}},  // stage 4
    {{0.2413651341592666855, 0.0, -0.88454947932828608534, 0.92483400326179200312}},  // stage 5
    {{0.037037037037037037037, 0.0, 0.0, 0.17082860872947387128,
      0.12546768756682242502}},  // stage 6
    {{0.037109375, 0.0, 0.0, 0.17025221101954403931, 0.060216538980455960685,
      -0.017578125}},  // stage 7
    {{0.037092000118504792711, 0.0, 0.0, 0.17038392571223999381, 0.10726203044637328465,
      -0.015319437748624401753, 0.0082737891638140228876}},  // stage 8
    {{0.62411095871607571711, 0.0, 0.0, -3.3608926294469412941, -0.86821934684172600682,
      27.592099699446708305, 20.154067550477893409, -43.489884181069958848}},  // stage 9
    {{0.47766253643826436589, 0.0, 0.0, -2.4881146199716676419, -0.59029082683684299637,
      21.230051448181194235, 15.279233632882423583, -33.288210968984862919,
      -0.020331201708508626136}},  // stage 10
    {{-0.93714243008598732572, 0.0, 0.0, 5.1863724288440637083, 1.0914373489967295782,
      -8.1497870107469261251, -18.520065659996959864, 22.739487099350504282, 2.4936055526796523899,
      -3.0467644718982195004}},  // stage 11
    {{2.2733101475165382079, 0.0, 0.0, -10.534495466737250198, -2.0008720582248624991,
      -17.958931863118798917, 27.948884529419960051, -2.8589982771350236947, -8.8728569335306295443,
      12.360567175794303065, 0.64339274601576353036}},  // stage 12
    {{0.054293734116568762238, 0.0, 0.0, 0.0, 0.0, 4.4503128927524088814, 1.891517899314500383,
      -5.8012039600105847815, 0.31116436695781989441, -0.15216094966251607856,
      0.20136540080403034837, 0.044710615727772590518}},  // the step
    {{-0.18980075407240761571, 0.0, 0.0, 0.0, 0.0, 4.4503128927524088814, 1.891517899314500383,
      -5.8012039600105847815, -0.42268232132379196293, -0.15216094966251607856,
      0.20136540080403034837, 0.022651792198360825812}},  // third-order
    {{0.013120044994194880733, 0.0, 0.0, 0.0, 0.0, -1.2251564463762044407, -0.49575894965725019152,
      1.664377182454986537, -0.35032884874997368169, 0.33417911871301747903,
      0.081923206485115712466, -0.022355307863886295259}},  // fifth-order
}};

}  // namespace dop853

/// Dormand and Prince's method of order 8 with twelve evaluations a step: dearer a step than RK4,
/// far cheaper for small errors. With a tolerance it chooses its own steps, so that the error of
/// each stays below that part of the state, by the estimate and the controller of DOP853.
///
/// `Vector` is the type of q and of v: double, or a fixed-size or dynamic Eigen vector.
/// The constructor takes one vector of the right size; a step allocates nothing.
template <class Vector>
class Dop853 {
 public:
  /// tolerance: error of one step relative to the norms of q and v; 0: none, fixed steps.
  /// rounding: what of an acceleration is noise.
  explicit Dop853(const Vector& like, double tolerance = 0.0, double rounding = 0.0)
      : q_(like), tolerance_(tolerance), rounding_(rounding) {
    v_.fill(like);
    a_.fill(like);
  }

  /// Forgets the step that it would try next.
  void restart() { next_ = std::numeric_limits<double>::infinity(); }
  void expect_rounding(double rounding) { rounding_ = std::max(rounding_, rounding); }

  /// Moves q and v from t to t + h, or, with a tolerance, as far towards it as one step can go;
  /// returns how far. `acceleration(t, q, v, a)` writes q̈ into a. Throws NoStep when no step is
  /// short enough for the tolerance.
  template <class Acceleration>
  double step(Acceleration&& acceleration, double t, Vector& q, Vector& v, double h) {
    v_[0] = v;
    acceleration(t, q, v, a_[0]);
    if (tolerance_ == 0.0) {
      find_stages<1>(acceleration, t, q, v, h);
    } else {
      h /= std::max(1.0, std::ceil(h / next_));  // no short last step
      double growth = 5.0;
      while (true) {
        find_stages<1>(acceleration, t, q, v, h);
        const double error = estimate(q, v, h);
        const double factor = std::isfinite(error) ? 0.9 * std::pow(error, -0.125) : 0.0;
        next_ = h * std::clamp(factor, 0.2, growth);
        if (error <= 1.0) break;
        h = next_;
        growth = 1.0;  // after a failure the next step is no longer than this one
        if (t + 0.01 * h == t) throw NoStep("no step is short enough for the tolerance");
      }
    }
    each_entry(q, [&](const auto& at) {
      at(q) += h * sum<dop853::whole_step>(v_, at);
      at(v) += h * sum<dop853::whole_step>(a_, at);
    });
    return h;
  }

 private:
  using Stages = std::array<Vector, dop853::stages>;

  /// Calls f(at) for all entries, two at a time, at(x) being those of x: what needs one pass
  /// through memory takes one.
  template <class F>
  static void each_entry(const Vector& like, F&& f) {
    if constexpr (std::is_same_v<Vector, double>) {
      f([](auto& x) -> auto& { return x; });
    } else {
      Eigen::Index k = 0;
      for (; k + 1 < like.size(); k += 2)
        f([k](auto& x) { return Two<decltype(x)>(x.data() + k); });
      if (k < like.size()) f([k](auto& x) -> auto& { return x[k]; });
    }
  }

  /// Σ w_j k_j with one row of the weights; those that are 0 are left out.
  template <std::size_t row, std::size_t j = (row < dop853::stages ? row : dop853::stages) - 1,
            class At>
  static auto sum(const Stages& k, const At& at) {
    constexpr double weight = dop853::weights[row][j];
    if constexpr (weight == 0.0) {
      return sum<row, j - 1>(k, at);
    } else {
      auto part = plain(weight * at(k[j]));
      if constexpr (j > 0) part = sum<row, j - 1>(k, at) + part;
      return part;
    }
  }

  template <std::size_t i, class Acceleration>
  void find_stages(Acceleration& acceleration, double t, const Vector& q, const Vector& v,
                   double h) {
    if constexpr (i < dop853::stages) {
      each_entry(q, [&](const auto& at) {
        at(q_) = at(q) + h * sum<i>(v_, at);
        at(v_[i]) = at(v) + h * sum<i>(a_, at);
      });
      acceleration(t + dop853::c[i] * h, q_, v_[i], a_[i]);
      find_stages<i + 1>(acceleration, t, q, v, h);
    }
  }

  /// The error of the step in units of the tolerance.
  double estimate(const Vector& q, const Vector& v, double h) {
    // The size of q and v is also how far they move, since either may pass through 0. What the
    // noise of the accelerations makes of them is not resolved: about rest there is nothing else.
    constexpr double several = 64.0;  // the weights of the stages amplify it
    const double rate = norm(v) + h * norm(a_[0]), noise = several * rounding_ * h;
    const double q_allowed = tolerance_ * (norm(q) + h * rate) + h * noise;
    const double v_allowed = tolerance_ * rate + noise;
    const auto relative = [&](double q_error, double v_error) {
      const double q_part = q_error == 0.0 ? 0.0 : q_error / q_allowed;
      const double v_part = v_error == 0.0 ? 0.0 : v_error / v_allowed;
      return h * std::sqrt(q_part * q_part + v_part * v_part);
    };
    const double five = relative(size<dop853::error_5>(v_), size<dop853::error_5>(a_));
    const double three = relative(size<dop853::error_3>(v_), size<dop853::error_3>(a_));
    return five == 0.0 ? 0.0 : five * five / std::hypot(five, 0.1 * three);
  }

  template <std::size_t row>
  double size(const Stages& k) {
    each_entry(q_, [&](const auto& at) { at(q_) = sum<row>(k, at); });
    return norm(q_);
  }

  template <class X>
  using Two = Eigen::Map<std::conditional_t<std::is_const_v<std::remove_reference_t<X>>,
                                            const Eigen::Vector2d, Eigen::Vector2d>>;
  static double plain(double x) { return x; }
  template <class Sum>
  static Eigen::Vector2d plain(const Sum& x) {
    return x;
  }

  static double norm(double x) { return std::abs(x); }
  template <class Column>
  static double norm(const Column& x) {
    return x.norm();
  }

  Vector q_;
  Stages v_, a_;
  double tolerance_, rounding_, next_ = std::numeric_limits<double>::infinity();
};

}  // namespace integrators
