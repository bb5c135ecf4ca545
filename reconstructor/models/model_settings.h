// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/models/appearance_model.h"
#include "reconstructor/models/baselines.h"
#include "reconstructor/radiance/radiance_image.h"
#include "reconstructor/surface/sample_visibility.h"

namespace sheen {

class ModelKind;

/// How images of differing exposure are brought to one level.
enum class ExposureCompensation {
  kOff,       ///< grey levels mean the same in all images
  kKnown,     ///< by exposure time and gain where a linear camera reports them
  kEstimate,  ///< as kKnown; where they are unknown, one robust gain per image (docs/decisions/exposure.md)
};

/// A value as a scene file has it; `monostate` is one of none of these types.
using SettingValue = std::variant<std::monostate, std::int64_t, double, std::string>;

/// Where a key of a scene file stands.
enum class SettingTable {
  kImages,    ///< [images]: what all models do with images
  kModel,     ///< [NAME]: what a person sets
  kAdvanced,  ///< [NAME.advanced]: what an engineer sets
  kStudy,     ///< [NAME.study]: other ways, to compare with
};

/// A key of a scene file and the value behind it. It refers to the settings that gave it.
struct SettingKey {
  std::string name;
  SettingTable table = SettingTable::kModel;
  std::function<SettingValue()> get;
  std::function<std::string(const SettingValue&)> set;  ///< takes the value over; else says what it must be
};

/// What a scene asks of a model. Each kind of model has its own beside what all models do with images.
struct ModelSettings {
  int hold_out_every = 8;  ///< every Nth image of a source is held out; 0 = none
  ExposureCompensation exposure = ExposureCompensation::kKnown;
  Sampling sampling = Sampling::kCubic;
  VisibilityOptions visibility;

  virtual ~ModelSettings() = default;
  virtual const char* kind() const = 0;  ///< name of the model's kind
  virtual std::unique_ptr<ModelSettings> clone() const = 0;
  /// All keys, those of [images] included.
  virtual std::vector<SettingKey> keys() = 0;
  /// Throws ConfigError when a value is out of range: "NAME: KEY must be ...".
  virtual void require_valid() const = 0;
  /// The surface of a model that makes its own, of what a camera sees; empty: the scene gives a mesh. Throws
  /// ConfigError for a camera of which it cannot be made.
  virtual std::optional<Mesh> own_mesh(const PosedCamera&) const { return std::nullopt; }
  /// What `--tolerance` is of: of the error between the images' lights, in grey levels; else it is a key of the
  /// settings.
  virtual bool tolerance_is_between_lights() const { return false; }
  /// Whether `own_mesh` makes one.
  virtual bool makes_mesh() const { return false; }
  /// Whether it takes a mesh where the scene gives one, although it could make its own.
  virtual bool takes_mesh() const { return false; }
  /// Why models of these settings cannot be one small file, though the kind's can; empty: they can.
  virtual std::string no_small_form() const { return {}; }
  virtual int effort_levels() const = 0;  ///< at least 1: level 0 is what these settings ask for
  virtual MemoryNeed memory_need(std::size_t vertices, std::size_t triangles) const = 0;
  /// A model of the mesh with these settings, at effort level 0. `scene`: of that mesh. Throws ConfigError as
  /// `require_valid` does.
  virtual std::unique_ptr<AppearanceModel> make_model(std::shared_ptr<const Mesh> mesh,
                                                      std::shared_ptr<const RayScene> scene) const = 0;
  /// For a snapshot of a model with these settings. `photographs`: whether to keep them for baselines that need them.
  virtual std::unique_ptr<Baselines> make_baselines(std::shared_ptr<const ModelSnapshot> snapshot,
                                                    bool photographs) const = 0;

 protected:
  ModelSettings() = default;
  ModelSettings(const ModelSettings&) = default;
  ModelSettings& operator=(const ModelSettings&) = default;
  /// The keys of [images].
  std::vector<SettingKey> image_keys();
  void require_valid_images() const;
};

/// Sets one key by name. Throws ConfigError where the settings have no such key, or it does not take the value.
void set(ModelSettings& settings, const std::string& key, const SettingValue& value);

SettingKey setting(std::string name, int& value, SettingTable table = SettingTable::kModel);
SettingKey setting(std::string name, double& value, SettingTable table = SettingTable::kModel);

/// A key whose values are words.
template <typename Enum>
SettingKey setting(std::string name, Enum& value, std::vector<std::pair<Enum, std::string>> words,
                   SettingTable table = SettingTable::kModel) {
  const auto get = [&value, words]() -> SettingValue {
    for (const auto& [meaning, word] : words)
      if (meaning == value) return word;
    return {};
  };
  const auto set = [&value, words](const SettingValue& given) -> std::string {
    std::string demand;
    for (std::size_t i = 0; i < words.size(); ++i) {
      const auto& [meaning, word] = words[i];
      if (given == SettingValue(word)) {
        value = meaning;
        return {};
      }
      demand += (i == 0 ? "must be \"" : i + 1 == words.size() ? "\" or \"" : "\", \"") + word;
    }
    return demand + '"';
  };
  return {std::move(name), table, get, set};
}

}  // namespace sheen
