// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_file.h"

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "reconstructor/lumigraph_file/encode/lumigraph_encoding.h"
#include "reconstructor/lumigraph_file/lumigraph_reader.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr const char *kViewsFile = "views.ilg", *kMeshFile = "mesh.ply";

}  // namespace

void save_lumigraph(const IntrinsicLumigraphSnapshot& model, const fs::path& folder, const ModelMetadata& metadata,
                    const StepsDone& progress) {
  make_folder(folder);
  save_ply(model.mesh(), folder / kMeshFile);
  write_file(folder / kViewsFile, encode_lumigraph(*model.data(), progress));
  write_file(
      folder / "model.json",
      OrderedJson{{"format", kLumigraphFormat}, {"views", kViewsFile}, {"mesh", kMeshFile}, {"metadata", metadata}}
              .dump(-1, ' ', false, Json::error_handler_t::replace) +
          "\n");
}

std::shared_ptr<const IntrinsicLumigraphSnapshot> load_lumigraph(const fs::path& folder) {
  const fs::path file = folder / kViewsFile;
  auto data = std::make_shared<const LumigraphData>(read_lumigraph(read_file(file), file.string()));
  auto mesh = std::make_shared<const Mesh>(load_mesh_unchanged(folder / kMeshFile));
  auto occluders = data->of_images ? nullptr : std::make_shared<const Occluders>(*mesh);
  return std::make_shared<IntrinsicLumigraphSnapshot>(std::move(mesh), std::move(occluders), std::move(data), 1);
}

}  // namespace sheen
