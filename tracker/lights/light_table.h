// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "tracker/lights/frame_lights.h"

namespace sheen {

/// A gantry, or a controller that switches lamps: a table of their places, and for each frame an entry of it, by the
/// frame's number or by a file that the controller writes while it works. Refuses a frame as "beyond_light_table" and,
/// when its line has not come within a fifth of a second, as "no_light_index".
class LightTable : public FrameLights {
 public:
  /// Throws FileError, also when the index is there and has a line that is not FRAME,ENTRY.
  explicit LightTable(const LightOptions& options);
  Answer of(const Capture& frame) override;

 private:
  std::optional<std::uint64_t> entry_of(std::uint64_t frame_id);
  void read_index();

  std::string table_;
  std::vector<LightState> lights_;
  std::filesystem::path index_;
  std::uint64_t first_frame_;
  std::map<std::uint64_t, std::uint64_t> entries_;  ///< by frame, as far as the index has been read
  std::size_t read_bytes_ = 0, read_lines_ = 0;
};

}  // namespace sheen
