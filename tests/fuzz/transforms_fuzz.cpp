// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>

#include "common/base/errors.h"
#include "common/datasets/transforms_json.h"

namespace {

/// Every image is there, so that the fuzzer gets past the look-up; sizes follow from the name.
const sheen::ImageFiles kImages{[](const std::string& name) { return std::filesystem::path(name); },
                                [](const std::filesystem::path& image) {
                                  return sheen::ImageSize{static_cast<int>(image.native().size() % 5000), 480};
                                }};

}  // namespace

/// Whatever the text, the parser returns sound views or says what is wrong.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    for (const sheen::DatasetView& view :
         sheen::parse_transforms("fuzz", {reinterpret_cast<const char*>(data), size}, kImages)) {
      const bool sound = sheen::validation_error(view.camera).empty() && !view.name.empty() &&
                         view.camera_from_object.matrix().allFinite() &&
                         std::abs(view.camera_from_object.rotation.norm() - 1) < 1e-6;
      if (!sound) std::abort();
    }
  } catch (const sheen::FileError&) {
    return 0;
  }
  return 0;
}
