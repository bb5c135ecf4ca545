// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <vector>

#include "common/capture/capture.h"
#include "common/stage/stage_layout.h"

namespace sheen {

/// Puts a stage together from where captures saw its tags: so the captures of a session need no file that says where
/// they stand.
class StageSightings {
 public:
  void add(const Capture& capture);
  /// Of the tags that were seen; each corner where the middle one of its sightings has it.
  StageLayout layout() const;

 private:
  std::map<int, std::array<std::array<std::vector<double>, 2>, 4>> corners_;  ///< per id: of each corner x and y
};

}  // namespace sheen
