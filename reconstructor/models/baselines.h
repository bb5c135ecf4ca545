// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "reconstructor/models/model_snapshot.h"

namespace sheen {

/// Another way to show what the same images show.
struct Baseline {
  std::string key;    ///< in reports
  std::string title;  ///< for a person
  std::shared_ptr<const Appearance> appearance;
  double disk_bytes = 0;    ///< of what it is made from, as files; the mesh not counted
  double memory_bytes = 0;  ///< that it keeps in memory; the mesh not counted
};

/// Another way to say how well a surface is known, per triangle seen from an eye; 0 = well known .. 1.
struct BaselineHeuristic {
  std::string title;
  std::function<std::vector<float>(const Eigen::Vector3d& eye)> of;
};

/// What a saved model is compared with: made from the images that the model was built from.
class Baselines {
 public:
  virtual ~Baselines() = default;
  /// An image that is in the model. `exposure_gain`: that the model divided it by. `repeated`: the model took nothing
  /// of it.
  virtual void add(const Capture& capture, float exposure_gain, bool repeated) = 0;
  virtual std::shared_ptr<const Appearance> constant_colour() const = 0;
  /// Those that keep the photographs, from the weakest to the strongest; none where photographs were not asked for.
  /// `model_bytes`: of the model's files, to which photographs may be brought.
  virtual std::vector<Baseline> from_photographs(std::size_t model_bytes) const = 0;
  virtual BaselineHeuristic heuristic() const = 0;
};

}  // namespace sheen
