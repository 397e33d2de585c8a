#include "exact.hpp"

#include <cmath>

namespace ground {

Decay decay(double ks, double kd, double t) {
  const double gamma = 0.5 * kd, d = gamma * gamma - ks;
  if (d <= 0.0) {
    const double Omega = std::sqrt(-d);
    const double s = Omega * t < 1e-8 ? t : std::sin(Omega * t) / Omega, c = std::cos(Omega * t);
    const double f = std::exp(-gamma * t);
    return {f * (c + gamma * s), -f * ks * s, ks, kd};
  }
  const double w = std::sqrt(d), rho1 = ks / (gamma + w);  // the slow rate; the fast one is γ + w
  const double f = std::exp(-rho1 * t), s = -std::expm1(-2.0 * w * t) / (2.0 * w);
  return {f * (1.0 + rho1 * s), -ks * f * s, ks, kd};
}

Exact exact(const Scene& scene, const Decay& left, double t) {
  Exact truth{left.e * scene.offset(), left.rate * scene.offset(), {}};
  const Eigen::Vector3d M(scene.mass, scene.mass, scene.inertia());
  const Eigen::Vector3d a = -left.kd * truth.v - left.ks * truth.q;
  truth.reaction = M.cwiseProduct(a) - scene.applied(t, truth.q.z());
  return truth;
}

}  // namespace ground
