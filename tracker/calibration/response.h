// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sheen {

/// A way in which a stored value v (of full scale) may follow from light: the light is g(v) times an unknown factor.
enum class ResponseModel {
  kLinear,  ///< g = v - b
  kSrgb,    ///< g = srgb_decode(v) - b
  kGamma,   ///< g = v^gamma - b
  kCurve,   ///< one of these plus a natural cubic spline
};
const char* to_string(ResponseModel model);

/// Light of a value, with its first two derivatives.
struct LightOfValue {
  double light = 0, slope = 0, bend = 0;
};

/// The light of stored values by a model, and the numbers of the model that are estimated.
class Response {
 public:
  Response() : Response(ResponseModel::kLinear) {}
  explicit Response(ResponseModel model);  ///< no black level; a gamma of 2.2; not a curve
  /// `base` with a spline over the values from `low` to `high`, which corrects nothing yet. The light of `high` stays
  /// as it is: that is the unknown factor.
  static Response curve_over(const Response& base, double low, double high);

  LightOfValue operator()(double value) const;
  /// The value of a light; `guess`: one that is near.
  double value(double light, double guess) const;
  /// Derivative of the light by the numbers.
  Eigen::VectorXd gradient(double value) const;
  /// b; of a gamma b and gamma; of a curve the corrections at its knots but the last.
  int unknowns() const;
  void move(const Eigen::VectorXd& step);

  ResponseModel model() const { return model_; }
  double gamma() const { return gamma_; }  ///< 1 where the model has none
  /// Where the light is 0, of full scale; below 0 where there is light at value 0.
  double black_level() const;

 private:
  LightOfValue base(double value) const;
  struct Between;

  ResponseModel model_, base_;
  double black_ = 0;  ///< b, light
  double gamma_ = 1;
  double low_ = 0, step_ = 1;       ///< the knots of a spline
  Eigen::VectorXd corrections_;     ///< at the knots
  Eigen::VectorXd bends_;           ///< second derivatives of the spline there
  Eigen::MatrixXd bends_of_knots_;  ///< that give them
};

}  // namespace sheen
