// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/camera_features.h"

#include <arv.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kSame = 0.01;   ///< part of a value by which a camera may round it
constexpr double kWhole = 1e-6;  ///< by which a number may miss the integer that it means; else the one below is set

std::string text_of(const char* value) {
  return value ? value : "";
}

/// What `get` reads; nothing where it fails.
template <typename Get>
auto read(Get get) -> std::optional<decltype(get(nullptr))> {
  GError* error = nullptr;
  auto value = get(&error);
  const bool failed = error != nullptr;
  g_clear_error(&error);
  if (failed) return std::nullopt;
  return value;
}

}  // namespace

bool holds(double asked, double got, double step) {
  return std::abs(got - asked) <= std::max(step, kSame * std::abs(asked));
}

std::string CameraFeatures::number_text(double value) {
  return format("%.6g", value);
}

bool CameraFeatures::has(const std::string& name) const {
  return arv_camera_is_feature_available(camera_, name.c_str(), nullptr);
}

bool CameraFeatures::is_integer(const std::string& name) const {
  ArvGcNode* const node = arv_device_get_feature(arv_camera_get_device(camera_), name.c_str());
  return ARV_IS_GC_INTEGER(node) && !ARV_IS_GC_FLOAT(node);
}

std::string CameraFeatures::unit(const std::string& name) const {
  ArvGcNode* const node = arv_device_get_feature(arv_camera_get_device(camera_), name.c_str());
  if (ARV_IS_GC_FLOAT(node)) return text_of(arv_gc_float_get_unit(ARV_GC_FLOAT(node)));
  return ARV_IS_GC_INTEGER(node) ? text_of(arv_gc_integer_get_unit(ARV_GC_INTEGER(node))) : "";
}

std::vector<std::string> CameraFeatures::choices(const std::string& name) const {
  guint count = 0;
  const auto list = read(
      [&](GError** e) { return arv_camera_dup_available_enumerations_as_strings(camera_, name.c_str(), &count, e); });
  if (!list) return {};
  const std::unique_ptr<const char*, void (*)(void*)> names(*list, g_free);
  return {names.get(), names.get() + count};
}

std::optional<std::string> CameraFeatures::text(const std::string& name) const {
  if (!has(name)) return std::nullopt;
  return read([&](GError** e) { return text_of(arv_camera_get_string(camera_, name.c_str(), e)); });
}

std::optional<double> CameraFeatures::number(const std::string& name) const {
  if (!has(name)) return std::nullopt;
  const bool whole = is_integer(name);
  return read([&](GError** e) {
    return whole ? double(arv_camera_get_integer(camera_, name.c_str(), e))
                 : arv_camera_get_float(camera_, name.c_str(), e);
  });
}

std::optional<bool> CameraFeatures::on(const std::string& name) const {
  if (!has(name)) return std::nullopt;
  return read([&](GError** e) { return bool(arv_camera_get_boolean(camera_, name.c_str(), e)); });
}

LockedFeature CameraFeatures::set_text(const std::string& name, const std::string& asked) const {
  return attempt(
      name, asked, [&](GError** e) { arv_camera_set_string(camera_, name.c_str(), asked.c_str(), e); },
      [&](GError** e) { return text_of(arv_camera_get_string(camera_, name.c_str(), e)); },
      [&](const std::string& got) { return got == asked; });
}

LockedFeature CameraFeatures::set_number(const std::string& name, double asked, double step) const {
  const bool whole = is_integer(name);
  return attempt(
      name, number_text(asked),
      [&](GError** e) {
        if (whole)
          arv_camera_set_integer(camera_, name.c_str(), static_cast<gint64>(std::floor(asked + kWhole)), e);
        else
          arv_camera_set_float(camera_, name.c_str(), asked, e);
      },
      [&](GError** e) {
        return number_text(whole ? double(arv_camera_get_integer(camera_, name.c_str(), e))
                                 : arv_camera_get_float(camera_, name.c_str(), e));
      },
      [&](const std::string& got) { return holds(asked, std::stod(got), step); });
}

LockedFeature CameraFeatures::set_off(const std::string& name) const {
  return attempt(
      name, "off", [&](GError** e) { arv_camera_set_boolean(camera_, name.c_str(), false, e); },
      [&](GError** e) { return std::string(arv_camera_get_boolean(camera_, name.c_str(), e) ? "on" : "off"); },
      [](const std::string& got) { return got == "off"; });
}

/// Sets, reads back, compares. A camera that refuses the value may have it already.
LockedFeature CameraFeatures::attempt(const std::string& name, const std::string& asked, const Call& set,
                                      const std::function<std::string(GError**)>& get,
                                      const std::function<bool(const std::string&)>& same) const {
  LockedFeature result{name, asked, {}, false};
  GError* error = nullptr;
  set(&error);
  const std::string refusal = error ? error->message : "";
  g_clear_error(&error);
  const std::string got = get(&error);
  if (error) {
    result.got = error->message;
    g_clear_error(&error);
    return result;
  }
  result.holds = same(got);
  result.got = result.holds || refusal.empty() ? got : got + " (" + refusal + ")";
  return result;
}

}  // namespace sheen
