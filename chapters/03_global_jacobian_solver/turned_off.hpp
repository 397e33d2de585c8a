#pragma once

#include "mechanism.hpp"

namespace dumbbell {

/// The dumbbell with each constraint solved by itself, as if the others did not push: of J W Jᵀ
/// only the diagonal is used. Each force keeps its own C̈ at zero, and the others then break it.
class OneByOne : public mechanics::Mechanism {
 public:
  explicit OneByOne(const Scene& scene, const mechanics::Method& method = {})
      : Mechanism(make_mechanism(scene, method)), free_(0, scene.gravity, 0, scene.gravity) {}

  void acceleration(double t, const Vector& q, const Vector& v, Vector& a) {
    Mechanism::acceleration(t, q, v, a);
    const Eigen::MatrixXd J = evaluation().jacobian();
    const Vector2d v1 = v.head<2>(), v2 = v.tail<2>();
    const Eigen::Vector3d Jdot_v(2 * v1.x() * v1.x(), 2 * v2.x() * v2.x(), (v2 - v1).squaredNorm());
    a = free_;  // W F
    for (int k = 0; k < 3; ++k) {
      const Vector W_Jt = system.W().cwiseProduct(J.row(k).transpose());
      const double lambda = -(Jdot_v[k] + J.row(k) * free_) / (J.row(k) * W_Jt);
      a += lambda * W_Jt;
    }
  }

 private:
  Eigen::Vector4d free_;
};

}  // namespace dumbbell
