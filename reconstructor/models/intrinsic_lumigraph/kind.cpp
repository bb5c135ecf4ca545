// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/kind.h"

#include "common/base/errors.h"
#include "reconstructor/models/intrinsic_lumigraph/gl/lumigraph_drawer.h"
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph_options.h"
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_file.h"

namespace sheen {
namespace {

class IntrinsicLumigraphKind : public ModelKind {
 public:
  const char* name() const override { return IntrinsicLumigraphOptions::kName; }
  const char* title() const override { return "intrinsic lumigraph"; }
  RigMotion motion() const override { return {.camera = Motion::kMoves, .light = Motion::kMoves}; }
  const char* file_format() const override { return kLumigraphFormat; }
  std::unique_ptr<ModelSettings> default_settings() const override {
    return std::make_unique<IntrinsicLumigraphOptions>();
  }
  std::shared_ptr<const ModelSnapshot> load(const std::filesystem::path& path) const override {
    return load_lumigraph(path);
  }
  bool compresses() const override { return false; }
  bool reads_file(std::string_view) const override { return false; }
  ModelMetadata file_metadata(const std::filesystem::path& file) const override {
    throw FileError(file.string(), "is not an intrinsic lumigraph: that is a folder");
  }
  void set_file_metadata(const std::filesystem::path& file, const ModelMetadata&) const override {
    throw FileError(file.string(), "is not an intrinsic lumigraph: that is a folder");
  }
  std::unique_ptr<ModelDrawer> make_drawer(const DrawerOptions&) const override {
    return std::make_unique<LumigraphDrawer>();
  }
};

}  // namespace

const ModelKind& intrinsic_lumigraph_kind() {
  static const IntrinsicLumigraphKind kind;
  return kind;
}

}  // namespace sheen
