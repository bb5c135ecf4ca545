// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/python/open_model.h"

#include <algorithm>

namespace sheen {

std::size_t OpenModel::images() const {
  return std::max(snapshot().cameras().size(), snapshot().lights().size());
}

SmoothView OpenModel::paint(const AskedView& view, const std::optional<Eigen::Vector3d>& light) const {
  return painter().paint(camera_of(view, snapshot()), light_of(light, snapshot()));
}

const ModelPainter& OpenModel::painter() const {
  std::call_once(first_picture_, [this] { painter_ = std::make_unique<const ModelPainter>(snapshot()); });
  return *painter_;
}

}  // namespace sheen
