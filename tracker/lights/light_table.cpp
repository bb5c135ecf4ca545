// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/light_table.h"

#include <charconv>
#include <chrono>
#include <fstream>
#include <string_view>
#include <thread>

#include "common/base/errors.h"
#include "common/datasets/light_list.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPatience{200}, kPoll{5};

/// FRAME,ENTRY
std::optional<std::pair<std::uint64_t, std::uint64_t>> parse_line(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  const char *at = line.data(), *end = at + line.size();
  std::pair<std::uint64_t, std::uint64_t> entry;
  const auto frame = std::from_chars(at, end, entry.first);
  if (frame.ec != std::errc() || frame.ptr == end || *frame.ptr != ',') return std::nullopt;
  const auto number = std::from_chars(frame.ptr + 1, end, entry.second);
  if (number.ec != std::errc() || number.ptr != end) return std::nullopt;
  return entry;
}

}  // namespace

LightTable::LightTable(const LightOptions& options)
    : table_(options.table.string()), index_(options.index), first_frame_(options.first_frame.value_or(0)) {
  for (const LitView& entry : load_lights(options.table)) lights_.push_back(entry.light);
  read_index();
}

FrameLights::Answer LightTable::of(const Capture& frame) {
  const std::optional<std::uint64_t> entry = entry_of(frame.camera_frame_id);
  if (!entry) return {std::nullopt, "no_light_index"};
  if (*entry >= lights_.size()) return {std::nullopt, "beyond_light_table"};
  return {lights_[*entry], {}};
}

std::optional<std::uint64_t> LightTable::entry_of(std::uint64_t frame_id) {
  if (index_.empty()) return frame_id - first_frame_;  // of an earlier frame: beyond every table
  for (const auto end = std::chrono::steady_clock::now() + kPatience;; std::this_thread::sleep_for(kPoll)) {
    if (const auto found = entries_.find(frame_id); found != entries_.end()) return found->second;
    if (std::chrono::steady_clock::now() >= end) return std::nullopt;
    read_index();
  }
}

/// What has come since the last time; a line that is not at its end yet waits for the next.
void LightTable::read_index() {
  if (index_.empty()) return;
  std::ifstream file(index_, std::ios::binary);
  if (!file) return;  // the controller has not begun
  file.seekg(static_cast<std::streamoff>(read_bytes_));
  for (std::string line; std::getline(file, line) && !file.eof();) {
    read_bytes_ += line.size() + 1;
    ++read_lines_;
    const auto entry = parse_line(line);
    if (!entry)
      throw FileError(index_.string(), "line " + std::to_string(read_lines_) +
                                           ": must be FRAME,ENTRY: the number of a frame, and of its entry in " +
                                           table_ + ", from 0");
    entries_[entry->first] = entry->second;
  }
}

}  // namespace sheen
