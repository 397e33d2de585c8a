// Rows that nearly depend on others: those whose pivot in the factor of K = J W J^T is so small
// that K, which squares what J says, cannot tell what is left of them.
//
// What is left of such a row is the combination y of rows whose gradient g = J^T y stands
// perpendicular, in the metric W, to those of all other rows. It is found from J itself (Gram and
// Schmidt, done twice), and keeps the digits that a pivot has lost. A set of such g, of length 1,
// adds to the solution of K x = b without the weak rows
//
//   x = K^-1 b + sum of y (y . b).
//
// One whose g is no longer than what the open joints make of it says nothing that the others do not
// say. It is left out, and its unknown is 0: of redundant rows, some get none of the load.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "mechanics/dynamics/entries.hpp"
#include "mechanics/dynamics/system.hpp"

namespace dynamics {
namespace {

// Of times that are not 0.
double shortest(const VectorXd& times) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const double time : times)
    if (time > 0) shortest = std::min(shortest, time);
  return shortest;
}

}  // namespace

Evaluation::Geometry Evaluation::geometry() const {
  Geometry scene{VectorXd::Zero(layout_.rows), VectorXd::Zero(layout_.rows), 0};
  const auto place = [&](const ThingInfo& thing) {
    const auto index = static_cast<std::size_t>(thing.index);
    return thing.dof == 2 ? things_.particles[index].thing.x : things_.bodies[index].thing.x;
  };
  // What the scene spans, a radius of gyration, a lever. A J in m is one too.
  for (const ThingInfo& thing : layout_.things) {
    const Vector2d from_first = place(thing) - place(layout_.things.front());
    scene.size = std::max(scene.size, from_first.cwiseAbs().maxCoeff<Eigen::PropagateNaN>());
    if (thing.dof == 3)
      scene.size = std::max(scene.size, layout_.radius(thing.column) / std::sqrt(3.0));
  }
  for (const Layout::JBlock& block : layout_.J_blocks)
    for (int k = 0; k < block.r; ++k) {
      const double* J = J_.data() + block.J + k;
      double &x = scene.J_x[block.row + k], &theta = scene.J_theta[block.row + k];
      x = std::max({x, std::abs(J[0]), std::abs(J[block.r])});
      if (block.dof == 3) theta = std::max(theta, std::abs(J[2 * block.r]));
    }
  for (const JointInfo& joint : layout_.joints)
    for (int k = 0; k < joint.r; ++k) {
      const double x = scene.J_x[joint.at.row + k], lever = scene.J_theta[joint.at.row + k] / x;
      if (x > 0)
        scene.size =
            std::max({scene.size, lever, std::string_view(joint.unit[k]) == "m^2" ? x : 0});
    }
  return scene;
}

// What of row k of x, which is C or its rounding, is of the scene's size, or an angle in rad.
double Evaluation::Geometry::part(const VectorXd& x, Eigen::Index k) const {
  return std::abs(x[k]) / std::max(size * J_x[k], J_theta[k]);
}

// The largest part, of the rows that take part in y and have a gradient.
double Evaluation::Geometry::largest_part(const VectorXd& x, const VectorXd& y) const {
  constexpr double little = 1e-6;
  const double most = y.size() == 0 ? 0 : y.cwiseAbs().maxCoeff();
  double largest = 0;
  for (Eigen::Index k = 0; k < x.size(); ++k)
    if (std::abs(y[k]) > little * most && (J_x[k] > 0 || J_theta[k] > 0))
      largest = std::max(largest, part(x, k));
  return largest;
}

// Takes from y and g what the strong rows hold.
void Evaluation::clear_of_strong(WeakRow& weak) {
  mu_.setZero();
  add_J(-1, layout_.W.cwiseProduct(weak.g), mu_);
  K_.solve(mu_);
  weak.y += mu_;
  add_Jt(mu_, weak.g);
}

// Takes from y and g what a weak row holds that is kept.
void Evaluation::clear_of(const WeakRow& kept, WeakRow& weak) const {
  const double part = kept.g.dot(layout_.W.cwiseProduct(weak.g));
  weak.y -= part * kept.y;
  weak.g -= part * kept.g;
}

// How fast a thing moves, in sizes of the scene or in rad.
double Evaluation::speed(int column, int dof, const VectorXd& v) const {
  const double speed = v.segment<2>(column).norm() / geometry_.size;
  return dof == 3 ? std::max(speed, std::abs(v[column + 2])) : speed;
}

// How much of the gradients that y adds up is left in g: from 1 to 0. Lengths count in metres here,
// whatever the masses, since rows depend on one another by geometry; an angle counts by the scene's
// size.
double Evaluation::left_of(const WeakRow& weak) const {
  VectorXd terms = VectorXd::Zero(a_.size());
  for (const Layout::JBlock& block : layout_.J_blocks)
    for (int k = 0; k < block.r; ++k)
      for (int i = 0; i < block.dof; ++i)
        terms[block.column + i] += std::abs(J_[block.J + k + i * block.r] * weak.y[block.row + k]);
  double left = 0, all = 0;
  for (const ThingInfo& thing : layout_.things)
    for (int i = 0; i < thing.dof; ++i) {
      const double unit = i < 2 ? geometry_.size : 1;
      left = std::max(left, unit * std::abs(weak.g[thing.column + i]));
      all = std::max(all, unit * terms[thing.column + i]);
    }
  return left > 0 ? left / all : 0;
}

// Sets the rows aside that the factor cannot be trusted with, and sorts them into those that are
// kept and those that are left out.
//
// Joints that are open by a part d of the scene turn the gradients by about d. In a combination of
// which s is left they make an error d / s, and a Newton step as long. It can be trusted while that
// is small beside s itself, by which the gradients change on the way. Closed joints are open by
// rounding. Of joints that are wide open nothing of this holds, nor of a state that is not finite:
// there, and where it would take too long, rows go by their pivots alone.
void Evaluation::find_weak_rows() {
  if (K_.complete() && closed()) return;
  geometry_ = geometry();
  const VectorXd all = VectorXd::Ones(layout_.rows);
  rounding_ = epsilon * std::max(1., geometry_.largest_part(size_, all));
  const double d = geometry_.largest_part(C_, all);
  constexpr double wide_open = 0.1, most_work = 1e7;
  // Which of redundant rows are left out must not be left to their order: a row of small pivot is
  // no better than the one that comes after it.
  K_.factor(0, K_.complete()
                   ? std::clamp(100 * d * d, BlockLdlt::smallest_pivot, BlockLdlt::small_pivot)
                   : BlockLdlt::small_pivot);
  double aside = 0;
  for (Eigen::Index row = 0; row < layout_.rows; ++row) aside += K_.set_aside(row);
  if (!(d < wide_open) || aside * aside * layout_.rows > most_work) {
    K_.factor(0, 8 * epsilon * layout_.rows);
    for (int row = 0; row < layout_.rows; ++row)
      if (K_.set_aside(row)) weak_.push_back({row, {}, {}, 1, 0});
    return;
  }

  for (int row = 0; row < layout_.rows; ++row)
    if (K_.set_aside(row)) {
      weak_.push_back({row, VectorXd::Unit(layout_.rows, row), VectorXd::Zero(a_.size()), 0, 0});
      add_Jt(weak_.back().y, weak_.back().g);
      for (int twice = 0; twice < 2; ++twice) clear_of_strong(weak_.back());
    }
  for (; kept_ < weak_.size(); ++kept_) {
    const auto next = weak_.begin() + static_cast<std::ptrdiff_t>(kept_);
    for (auto weak = next; weak != weak_.end(); ++weak) weak->independence = left_of(*weak);
    std::iter_swap(next, std::max_element(next, weak_.end(), [](auto& a, auto& b) {
                     return a.independence < b.independence;
                   }));
    // A velocity along such a combination is known to rounding over s^2.
    const double open =
        std::max({1e5 * epsilon, 1e3 * rounding_, geometry_.largest_part(C_, next->y)});
    if (!(next->independence * next->independence > 10 * open)) break;
    clear_of_strong(*next);
    for (auto kept = weak_.begin(); kept != next; ++kept) clear_of(*kept, *next);
    const double square = next->g.dot(layout_.W.cwiseProduct(next->g));
    next->pivot = square / K_.diagonal()[next->row];
    next->y /= std::sqrt(square);
    next->g /= std::sqrt(square);
    for (auto weak = next + 1; weak != weak_.end(); ++weak) clear_of(*next, *weak);
  }
}

// Those of which nothing is left that can be trusted, or so little that care is needed.
int Evaluation::nearly_dependent_rows() const {
  int count = 0;
  for (std::size_t i = 0; i < weak_.size(); ++i)
    if (weak_[i].g.size() > 0) count += i >= kept_ || weak_[i].is_delicate();
  return count;
}

// Whether all of these depend on others to rounding. If joints are open, they do so everywhere.
bool Evaluation::wholly_dependent() const {
  return std::none_of(weak_.begin(), weak_.end(), [&](const WeakRow& weak) {
    return weak.independence > 1e4 * rounding_ && weak.is_delicate();
  });
}

// Whether the joints are closed so well that no row is set aside for their being open. It needs no
// geometry: K_kk is at most 6 W_theta times the square of what C_k is compared with there.
bool Evaluation::closed() const {
  constexpr double d = 1e-4;  // of which 100 times the square is smallest_pivot
  double square = 0;
  for (Eigen::Index row = 0; row < C_.size(); ++row)
    square = std::max(square, C_[row] * C_[row] / K_.diagonal()[row]);
  return 6 * square * largest_W_theta_ < d * d;
}

// NaN for each part of a reaction in which a combination of rows that is left out has a share. In a
// singular pose any multiple of that could be added to lambda. Of redundant joints the others carry
// what they would without.
Vector3d Evaluation::undetermined(JointHandle joint, int column) const {
  Vector3d unknown = Vector3d::Zero();
  constexpr double share = 1e-6, nan = std::numeric_limits<double>::quiet_NaN();
  const JointInfo& here = layout_.joints[static_cast<std::size_t>(joint.index)];
  for (std::size_t i = kept_; i < weak_.size(); ++i) {
    if (weak_[i].y.size() == 0) continue;
    const bool own = weak_[i].row >= here.at.row && weak_[i].row < here.at.row + here.r;
    const bool redundant = std::count(redundant_.begin(), redundant_.end(), weak_[i].row) > 0;
    if (limit_ ? !redundant || !own : !singular_ && !own) continue;
    double force = 0;  // the largest of the combination's, in all joints
    for (const Layout::JBlock& block : layout_.J_blocks) {
      const Vector3d part = reaction_of(weak_[i].y, block.joint, block.column);
      force = std::max({force, part.head<2>().norm(), std::abs(part.z()) / geometry_.size});
    }
    const Vector3d part = reaction_of(weak_[i].y, joint.index, column);
    for (int k = 0; k < 3; ++k)
      if (std::abs(part[k]) > share * force * (k < 2 ? 1 : geometry_.size)) unknown[k] = nan;
  }
  return unknown;
}

double Evaluation::independence(Eigen::Index row) const {
  for (const WeakRow& weak : weak_)
    if (weak.row == row) return weak.pivot;
  return K_.independence(row);
}

// Overwrites b with the solution x of K x = b, and adds J^T x to F: from the g, which have digits
// that a sum of J^T y has not when heavy things hang on light ones. The x of rows left out is 0.
void Evaluation::solve(VectorXd& b, VectorXd& F) {
  if (kept_ > 0) mu_ = b;
  K_.solve(b);
  add_Jt(b, F);
  for (std::size_t i = 0; i < kept_; ++i) {
    const double part = weak_[i].y.dot(mu_);
    b += part * weak_[i].y;
    F += part * weak_[i].g;
  }
}

void System::evaluate_on_constraints(double t, const VectorXd& q, const VectorXd& v,
                                     Evaluation& e) const {
  // What feedback asks for, in the state that was given.
  find_constraint(t, q, v, e);
  const VectorXd C = e.C_, feedback = -ks_ * e.C_ - kd_ * e.Cdot_;

  VectorXd q_on = q, v_on = v;
  project(t, q_on, v_on, e);
  set_up(t, q_on, v_on, e);
  const bool dependent = e.nearly_dependent_rows() > 0;
  const bool singular = dependent && is_singular_pose(t, q_on, v_on, e);
  e.lambda_ = e.b_;
  if (!singular || !find_limit(t, q_on, v_on, e)) e.solve(e.lambda_, e.F_);
  if (!feedback.isZero(0)) {
    VectorXd lambda = feedback;
    e.solve(lambda, e.F_);
    e.lambda_ += lambda;
  }
  e.C_ = C;
  e.a_ = layout_.W.cwiseProduct(e.F_) + 0 * q + 0 * v;
  e.nearly_dependent_ = dependent;
  e.singular_ = singular;
  e.solved_ = true;
}

// How fast the fastest thing moves, in sizes of the scene or in rad.
double System::speed(const VectorXd& v, const Evaluation& e) const {
  double speed = 0;
  for (const ThingInfo& thing : layout_.things)
    speed = std::max(speed, e.speed(thing.column, thing.dof, v));
  return speed;
}

// For each coordinate, the time in which its thing goes about `far` of the scene along v, or as
// much in rad. It is common to all that joints connect, and that of the fastest among the things
// that take part in what is nearly dependent: 0 where there is none, or none faster than `rest`.
VectorXd System::times_along(const VectorXd& v, double far, double rest,
                             const Evaluation& e) const {
  Eigen::VectorXi other = Eigen::VectorXi::LinSpaced(v.size(), 0, static_cast<int>(v.size()) - 1);
  const auto first_connected = [&](int column) {
    while (other[column] != column) column = other[column] = other[other[column]];
    return column;
  };
  const std::vector<Layout::JBlock>& blocks = layout_.J_blocks;
  for (std::size_t i = 1; i < blocks.size(); ++i)
    if (blocks[i].joint == blocks[i - 1].joint)
      other[first_connected(blocks[i].column)] = first_connected(blocks[i - 1].column);

  VectorXd fastest = VectorXd::Zero(v.size());
  for (const Evaluation::WeakRow& weak : e.weak_)
    if (weak.is_close())
      for (const Layout::JBlock& block : blocks)
        if (weak.y.segment(block.row, block.r).squaredNorm() > 1e-12 * weak.y.squaredNorm()) {
          double& speed = fastest[first_connected(block.column)];
          speed = std::max(speed, e.speed(block.column, block.dof, v));
        }
  VectorXd times = VectorXd::Zero(v.size());
  for (const ThingInfo& thing : layout_.things) {
    const double speed = fastest[first_connected(thing.column)];
    if (speed > rest) times.segment(thing.column, thing.dof).setConstant(far / speed);
  }
  return times;
}

// Whether rows that nearly depend on others here, where e is set up and will be again, do so for a
// moment only: a little further along v, or, where nothing moves, along some other motion that the
// joints allow.
bool System::is_singular_pose(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  // By geometry alone: the step leaves the joints open.
  const auto dependent_rows = [&] {
    return std::count_if(e.weak_.begin(), e.weak_.end(),
                         [](const Evaluation::WeakRow& weak) { return weak.is_close(); });
  };
  const auto dependent = dependent_rows();
  constexpr double far = 0.02, rest = 1e-9;
  VectorXd times = times_along(v, far, rest * speed(v, e), e);
  VectorXd step = times.cwiseProduct(v);
  const bool at_rest = step.isZero(0);
  if (at_rest) {
    VectorXd u(v.size());
    for (Eigen::Index i = 0; i < u.size(); ++i) u[i] = std::cos(1.0 + static_cast<double>(i * i));
    const double all = speed(u, e);
    VectorXd Ju = VectorXd::Zero(layout_.rows);
    e.add_J(1, u, Ju);
    e.correct(Ju, u);
    step = times_along(u, far, rest * all, e).cwiseProduct(u);
  }
  bool singular = false;
  if (!step.isZero(0)) {
    set_up(at_rest ? t : t + shortest(times), q + step, v, e);
    singular = dependent_rows() < dependent;
  }
  set_up(t, q, v, e);
  return singular;
}

// In a singular pose, as in the dead centre of a slider-crank, equation 1 does not say what a is,
// and close to it, not to many digits; but on the way through it a is smooth. It is interpolated
// between states before and behind it, q + s v and v brought onto the constraints, to the sixth
// order of s. So is lambda, unless a load would have to be held by forces that grow as 1 / s.
// Returns false where nothing moves, or the way is lost; else e has F + J^T lambda and lambda.
bool System::find_limit(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  // Their error of the sixth order is some 64 s^6 of them, as they turn twice as fast as the
  // things, and that of rounding 1 / s^3 of it.
  const VectorXd times = times_along(v, 0.6 * std::pow(e.rounding_, 1. / 9), 1e-9 * speed(v, e), e);
  bool passes = !times.isZero(0);
  const int dependent = e.nearly_dependent_rows();
  VectorXd a = VectorXd::Zero(q.size()), lambda = VectorXd::Zero(layout_.rows), near = lambda,
           far = lambda;
  for (const auto& [s, weight] :
       {std::pair(-3, 0.05), {-2, -0.3}, {-1, 0.75}, {1, 0.75}, {2, -0.3}, {3, 0.05}}) {
    if (!passes) break;
    const double t_s = t + s * shortest(times);
    VectorXd q_s = q + s * times.cwiseProduct(v), v_s = v;
    const bool closed = project(t_s, q_s, v_s, e).converged;
    set_up(t_s, q_s, v_s, e);
    e.lambda_ = e.b_;
    e.solve(e.lambda_, e.F_);
    passes = closed && e.nearly_dependent_rows() < dependent;
    a += weight * layout_.W.cwiseProduct(e.F_);
    lambda += weight * e.lambda_;
    if (std::abs(s) == 1) near += s * e.lambda_;
    if (s == 1) {
      e.redundant_.clear();
      for (std::size_t i = e.kept_; i < e.weak_.size(); ++i) e.redundant_.push_back(e.weak_[i].row);
    }
    if (std::abs(s) == 3) far += s / 3 * e.lambda_;
  }
  set_up(t, q, v, e);
  e.lambda_ = e.b_;
  if (!passes) return false;
  // What lambda changes by from side to side, in units that rows of all kinds share.
  const auto size = [&](const VectorXd& x) {
    return x.cwiseProduct(e.K_.diagonal().cwiseSqrt()).norm();
  };
  e.limit_ = !(size(near) > size(far) && size(near) > 1e-6 * size(lambda));
  if (e.limit_)
    e.lambda_ = lambda;
  else
    e.solve(e.lambda_, e.F_);
  e.F_ = layout_.M.cwiseProduct(a);
  return true;
}

}  // namespace dynamics
