// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/files/compact_file.h"

#include <future>

#include "common/base/files.h"
#include "common/base/log.h"
#include "reconstructor/light_field_file/light_field_file.h"
#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

void save_compact(const std::filesystem::path& file, std::string_view encoded, const ModelMetadata& metadata) {
  write_file(file, with_notes(kLightFieldFile, encoded, metadata, file.string()));
}

std::shared_ptr<const CompactLightField> load_compact(const std::filesystem::path& file, const ShowModel& show) {
  auto bytes = std::make_shared<const std::string>(read_file(file));
  std::future<void> shown;  // the smooth part: made ready beside the decoding, which is serial
  WhileDecoding while_decoding;
  if (show) {
    while_decoding.mesh = [&](const CompactModel& model) { show(bare_mesh(model.mesh, model.cameras)); };
    while_decoding.smooth = [&](QuantisedModel smooth) {
      shown = std::async(std::launch::async, [&show, smooth = std::move(smooth)]() mutable {
        show(std::make_shared<CompactLightField>(std::move(smooth).dequantised(in_parallel), nullptr));
      });
    };
  }
  CompactModel model = decode_light_field(*bytes, file.string(), in_parallel, while_decoding);
  if (shown.valid()) shown.get();
  if (model.missing_layers > 0)
    log_warning("model",
                file.string() + ": " + std::to_string(model.missing_layers) + " of " + std::to_string(model.layers) +
                    " layers are missing, the file was cut short: what is drawn is coarser than the model was");
  return std::make_shared<CompactLightField>(std::move(model), bytes);
}

ModelMetadata compact_metadata(std::string_view bytes, const std::string& file) {
  return notes_of(kLightFieldFile, bytes, file);
}

}  // namespace sheen
