// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

/// When it is chosen again how a patch interpolates between its views: as soon as there can be a choice, and then at
/// numbers of images that grow by a factor. Patches of differing phase choose at different images, which spreads the
/// work.
class ChoiceSchedule {
 public:
  explicit ChoiceSchedule(unsigned phase) : phase_(phase), due_(due_after(0)) {}

  static constexpr int kFirstChoice = 5;  ///< views; fewer say nothing about how fast a patch varies

  bool due(int images) const { return images >= due_; }
  void chosen_at(int images) { due_ = due_after(images); }

 private:
  int due_after(int images) const;

  unsigned phase_;
  int due_;  ///< images ingested when the next choice is
};

}  // namespace sheen
