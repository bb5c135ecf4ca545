// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace sheen {

/// A sum of weighted squared distances from planes and points (Garland and Heckbert 1997): x A x - 2 b x + c.
struct Quadric {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0;
  double weight = 0;  ///< of all planes

  /// From the plane through `point` with a unit normal.
  void add_plane(const Eigen::Vector3d& normal, const Eigen::Vector3d& point, double weight) {
    const double offset = normal.dot(point);
    A += weight * normal * normal.transpose();
    b += weight * offset * normal;
    c += weight * offset * offset;
    this->weight += weight;
  }
  void add_point(const Eigen::Vector3d& point, double weight) {
    A.diagonal().array() += weight;
    b += weight * point;
    c += weight * point.squaredNorm();
  }
  Quadric& operator+=(const Quadric& other) {
    A += other.A;
    b += other.b;
    c += other.c;
    weight += other.weight;
    return *this;
  }
  double at(const Eigen::Vector3d& x) const { return x.dot(A * x - 2 * b) + c; }
  /// Where it is least. A point must have been added: else there may be no such place.
  Eigen::Vector3d least() const { return A.inverse() * b; }
};

}  // namespace sheen
