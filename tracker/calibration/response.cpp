// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/response.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr int kKnots = 12;
constexpr double kSmallestValue = 1e-4;  ///< nearer to 0 the power of a gamma is a line
constexpr double kUsualGamma = 2.2;
constexpr int kInversions = 30;
constexpr double kInverted = 1e-10, kSmallestSlope = 1e-3;

/// sRGB (IEC 61966-2-1) with its derivatives, continued by its line below 0.
LightOfValue srgb(double v) {
  if (v <= 0.04045) return {v / 12.92, 1 / 12.92, 0};
  const double base = (v + 0.055) / 1.055;
  return {std::pow(base, 2.4), 2.4 / 1.055 * std::pow(base, 1.4), 2.4 * 1.4 / (1.055 * 1.055) * std::pow(base, 0.4)};
}

LightOfValue power(double v, double gamma) {
  if (v > kSmallestValue)
    return {std::pow(v, gamma), gamma * std::pow(v, gamma - 1), gamma * (gamma - 1) * std::pow(v, gamma - 2)};
  const double slope = std::pow(kSmallestValue, gamma - 1);
  return {slope * v, slope, 0};
}

/// Second derivatives at the knots of the natural cubic spline through values at them: the matrix that gives them.
Eigen::MatrixXd natural_bends(int knots, double step) {
  Eigen::MatrixXd left = Eigen::MatrixXd::Identity(knots, knots), right = Eigen::MatrixXd::Zero(knots, knots);
  for (int i = 1; i + 1 < knots; ++i) {
    left.block<1, 3>(i, i - 1) << 1, 4, 1;
    right.block<1, 3>(i, i - 1) << 1, -2, 1;
  }
  return left.partialPivLu().solve(right * (6 / (step * step)));
}

}  // namespace

const char* to_string(ResponseModel model) {
  switch (model) {
    case ResponseModel::kLinear:
      return "linear";
    case ResponseModel::kSrgb:
      return "srgb";
    case ResponseModel::kGamma:
      return "gamma";
    case ResponseModel::kCurve:
      break;
  }
  return "curve";
}

Response::Response(ResponseModel model)
    : model_(model), base_(model), gamma_(model == ResponseModel::kGamma ? kUsualGamma : 1) {}

Response Response::curve_over(const Response& base, double low, double high) {
  Response curve = base;
  curve.model_ = ResponseModel::kCurve;
  curve.low_ = low;
  curve.step_ = (high - low) / (kKnots - 1);
  curve.corrections_ = Eigen::VectorXd::Zero(kKnots);
  curve.bends_of_knots_ = natural_bends(kKnots, curve.step_);
  curve.bends_ = Eigen::VectorXd::Zero(kKnots);
  return curve;
}

LightOfValue Response::base(double value) const {
  LightOfValue g{value, 1, 0};
  if (base_ == ResponseModel::kSrgb) g = srgb(value);
  if (base_ == ResponseModel::kGamma) g = power(value, gamma_);
  g.light -= black_;
  return g;
}

/// Weights of the two knots beside a value, and of the second derivatives there (Press et al., Numerical Recipes 3.3).
struct Response::Between {
  int left = 0;
  double a = 0, b = 0;            ///< of the knots
  double bend_a = 0, bend_b = 0;  ///< of the second derivatives there

  /// `slope`: the derivative in place of the value.
  Between(double place, double h, int knots, bool slope) {
    const double inside = std::clamp(place, 0.0, double(knots - 1)), beyond = place - inside;
    left = std::min(static_cast<int>(inside), knots - 2);
    b = inside - left;
    a = 1 - b;
    const double rise_a = -(3 * a * a - 1) * h / 6, rise_b = (3 * b * b - 1) * h / 6;
    bend_a = slope ? rise_a : (a * a * a - a) * h * h / 6 + beyond * h * rise_a;
    bend_b = slope ? rise_b : (b * b * b - b) * h * h / 6 + beyond * h * rise_b;
    a = slope ? -1 / h : a - beyond;  // beyond the knots the spline goes on as a line
    b = slope ? 1 / h : b + beyond;
  }
  template <typename Values>
  auto of(const Values& corrections, const Values& bends) const {
    return a * corrections[left] + b * corrections[left + 1] + bend_a * bends[left] + bend_b * bends[left + 1];
  }
};

LightOfValue Response::operator()(double value) const {
  LightOfValue g = base(value);
  if (model_ != ResponseModel::kCurve) return g;
  const double place = (value - low_) / step_;
  const auto knots = static_cast<int>(corrections_.size());
  g.light += Between(place, step_, knots, false).of(corrections_, bends_);
  g.slope += Between(place, step_, knots, true).of(corrections_, bends_);
  if (place > 0 && place < knots - 1) {
    const auto left = static_cast<int>(place);
    g.bend += (left + 1 - place) * bends_[left] + (place - left) * bends_[left + 1];
  }
  return g;
}

Eigen::VectorXd Response::gradient(double value) const {
  if (model_ == ResponseModel::kCurve) {
    const Between at((value - low_) / step_, step_, static_cast<int>(corrections_.size()), false);
    Eigen::VectorXd row =
        at.bend_a * bends_of_knots_.row(at.left).transpose() + at.bend_b * bends_of_knots_.row(at.left + 1).transpose();
    row[at.left] += at.a;
    row[at.left + 1] += at.b;
    return row.head(unknowns());
  }
  Eigen::VectorXd row = Eigen::VectorXd::Constant(unknowns(), -1);
  if (model_ == ResponseModel::kGamma) row[1] = value > kSmallestValue ? std::pow(value, gamma_) * std::log(value) : 0;
  return row;
}

int Response::unknowns() const {
  if (model_ == ResponseModel::kCurve) return static_cast<int>(corrections_.size()) - 1;
  return model_ == ResponseModel::kGamma ? 2 : 1;
}

void Response::move(const Eigen::VectorXd& step) {
  if (model_ == ResponseModel::kCurve) {
    corrections_.head(unknowns()) += step;
    bends_ = bends_of_knots_ * corrections_;
    return;
  }
  black_ += step[0];
  if (model_ == ResponseModel::kGamma) gamma_ = std::clamp(gamma_ + step[1], 0.2, 5.0);
}

double Response::value(double light, double guess) const {
  double value = guess;
  for (int i = 0; i < kInversions; ++i) {
    const LightOfValue g = (*this)(value);
    const double step = (light - g.light) / std::max(g.slope, kSmallestSlope);
    value = std::clamp(value + std::clamp(step, -0.2, 0.2), -1.0, 2.0);
    if (std::abs(step) < kInverted) break;
  }
  return value;
}

double Response::black_level() const {
  double low = -1, high = 1;  // g rises through 0 between them
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    ((*this)(middle).light < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace sheen
