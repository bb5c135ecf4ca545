// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/source_uri.h"

#include "common/base/errors.h"
#include "tracker/sources/aravis_source.h"
#include "tracker/sources/dataset_source.h"
#include "tracker/sources/stream_address.h"
#include "tracker/sources/video_source.h"

namespace sheen {

SourceUri parse_source_uri(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string scheme = text.substr(0, colon);
  const std::string target = colon == std::string::npos ? "" : text.substr(colon + 1);
  const auto with = [&](SourceKind kind) {
    if (target.empty()) throw ConfigError("source \"" + without_password(text) + "\" names nothing behind the colon");
    return SourceUri{kind, target};
  };
  if (colon != std::string::npos && scheme == "aravis") return with(SourceKind::kAravis);
  if (colon != std::string::npos && scheme == "video") return with(SourceKind::kVideo);
  if (colon != std::string::npos && scheme == "dataset") return with(SourceKind::kDataset);
  const std::string shown = without_password(text);
  if (address_error(text).empty())
    throw ConfigError("source \"" + shown + "\" is the address of a stream: write video:" + shown);
  throw ConfigError("source \"" + shown + "\" is not one of aravis:ID, video:PATH, video:ADDRESS, dataset:DIR");
}

std::unique_ptr<FrameSource> open_source(const SourceUri& uri, const SourceSettings& settings) {
  switch (uri.kind) {
    case SourceKind::kAravis:
      return std::make_unique<AravisSource>(uri.target, settings);
    case SourceKind::kVideo:
      return open_video(uri.target, settings);
    case SourceKind::kDataset:
      return std::make_unique<DatasetSource>(uri.target);
  }
  throw ConfigError("unknown kind of source");
}

}  // namespace sheen
