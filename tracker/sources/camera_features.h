// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

struct _ArvCamera;
struct _GError;

namespace sheen {

/// A feature that was set, and what the camera says of it afterwards.
struct LockedFeature {
  std::string feature, asked, got;
  bool holds = false;
};

/// Whether a value read back is the one asked for: to 1 %, or to a step of `step`.
bool holds(double asked, double got, double step);

/// A GenICam camera's features by name. A number may be a float or an integer, as the camera describes it. An error of
/// the camera is a sentence in place of a value.
class CameraFeatures {
 public:
  explicit CameraFeatures(_ArvCamera* camera) : camera_(camera) {}

  bool has(const std::string& name) const;
  std::string unit(const std::string& name) const;                  ///< as it is described; often empty
  std::vector<std::string> choices(const std::string& name) const;  ///< those that can be chosen now

  /// What it is set to; nothing where the camera has no such feature or does not say.
  std::optional<std::string> text(const std::string& name) const;
  std::optional<double> number(const std::string& name) const;
  std::optional<bool> on(const std::string& name) const;

  LockedFeature set_text(const std::string& name, const std::string& asked) const;
  LockedFeature set_number(const std::string& name, double asked, double step) const;
  LockedFeature set_off(const std::string& name) const;

  static std::string number_text(double value);

 private:
  using Call = std::function<void(_GError**)>;
  LockedFeature attempt(const std::string& name, const std::string& asked, const Call& set,
                        const std::function<std::string(_GError**)>& get,
                        const std::function<bool(const std::string&)>& same) const;
  bool is_integer(const std::string& name) const;

  _ArvCamera* camera_;
};

}  // namespace sheen
