// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/served_model.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace sheen {
namespace {

constexpr double kFarthestEye = 1e9;  // metres

template <typename Number>
bool read(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

std::optional<DeskQuestion> desk_question(std::string_view scene, std::string_view changes, std::string_view eye,
                                          bool moved) {
  DeskQuestion question{.moved = moved};
  if (!read(scene, question.scene) || !read(changes, question.changes)) return std::nullopt;
  if (std::count(eye.begin(), eye.end(), ',') != 2) return std::nullopt;
  for (double& coordinate : question.eye) {
    const std::size_t end = std::min(eye.find(','), eye.size());
    if (!read(eye.substr(0, end), coordinate) || !(std::abs(coordinate) < kFarthestEye)) return std::nullopt;
    eye.remove_prefix(std::min(end + 1, eye.size()));
  }
  return question;
}

}  // namespace sheen
