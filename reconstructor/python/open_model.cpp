// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/python/open_model.h"

#include <algorithm>

#include "common/base/errors.h"
#include "common/image/exr.h"
#include "reconstructor/commands/picture_layers.h"

namespace sheen {

std::size_t OpenModel::images() const {
  return std::max(snapshot().cameras().size(), snapshot().lights().size());
}

SmoothView OpenModel::paint(const AskedView& view, const std::optional<Eigen::Vector3d>& light) const {
  return painter().paint(camera_of(view, snapshot()), light_of(light, snapshot()));
}

std::vector<std::pair<std::string, ImageF>> OpenModel::layers(const std::vector<std::string>& names,
                                                              const AskedView& view,
                                                              const std::optional<Eigen::Vector3d>& light) const {
  for (const std::string& name : names)
    if (const std::string wrong = is_layer().error(name); !wrong.empty()) throw ConfigError("layers: " + wrong);
  const PictureLayers layers(names, saved_.snapshot, path_.string());
  ExrFile file;
  layers.add(painter().rays(), painter().place_of(camera_of(view, snapshot())),
             painter().light_of(sheen::light_of(light, snapshot())), file);
  std::vector<std::pair<std::string, ImageF>> pictures;
  for (ExrPart& part : file.parts) pictures.emplace_back(part.name, std::move(part.image));
  return pictures;
}

const ModelPainter& OpenModel::painter() const {
  std::call_once(first_picture_, [this] { painter_ = std::make_unique<const ModelPainter>(snapshot()); });
  return *painter_;
}

}  // namespace sheen
