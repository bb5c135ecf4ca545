// SPDX-License-Identifier: Apache-2.0
// What the page's worker calls. One model; numbers and addresses of memory go in and out. A call that fails gives -1,
// and `sheen_table(kError)` says why.
#include <emscripten.h>

#include <cstdint>
#include <vector>

#include "reconstructor/page/wasm/exchange.h"
#include "reconstructor/page/wasm/page_model.h"

namespace {

using sheen::PageModel;
using sheen::page::table_of;
using sheen::page::tried;

enum TableName : std::uint32_t {
  kError,
  kScene,
  kCameras,
  kVertices,
  kTriangles,
  kEdges,
  kPlaces,
  kMeans,
  kTerms,
  kCoefficients
};

PageModel& model() {
  static PageModel model("this model");
  return model;
}
}  // namespace

extern "C" {

/// Room for so many bytes more of the file.
EMSCRIPTEN_KEEPALIVE char* sheen_more(std::uint32_t bytes) {
  return sheen::page::room_for(bytes);
}

/// PageModel::read of what is there.
EMSCRIPTEN_KEEPALIVE int sheen_read(int whole) {
  return tried([&] { return model().read(sheen::page::file(), whole != 0); });
}

/// Bytes of the next rows of terms, which are then the table `kTerms`.
EMSCRIPTEN_KEEPALIVE int sheen_next_terms() {
  return tried([] { return model().next_terms().size(); });
}

/// 0; then the table `kCoefficients` is that of the eye.
EMSCRIPTEN_KEEPALIVE int sheen_look(double x, double y, double z) {
  return tried([&] {
    model().look_from({x, y, z});
    return 0;
  });
}

EMSCRIPTEN_KEEPALIVE float sheen_exposure(double x, double y, double z) {
  return model().exposure_at({x, y, z});
}
EMSCRIPTEN_KEEPALIVE int sheen_max_terms() {
  return model().max_terms();
}
EMSCRIPTEN_KEEPALIVE int sheen_missing_layers() {
  return model().missing_layers();
}
EMSCRIPTEN_KEEPALIVE std::uint32_t sheen_term_texels() {
  return static_cast<std::uint32_t>(model().term_texels());
}

/// Address and length of a table, two numbers of 32 bits; until the next call.
EMSCRIPTEN_KEEPALIVE const sheen::page::Table* sheen_table(std::uint32_t name) {
  static sheen::page::Table table;
  static std::vector<double> scene;
  static std::vector<float> cameras;
  static std::vector<std::uint32_t> edges;
  switch (name) {
    case kScene:
      table = table_of(scene = model().scene());
      break;
    case kCameras:
      table = table_of(cameras = model().cameras());
      break;
    case kVertices:
      table = table_of(model().mesh().vertices);
      break;
    case kTriangles:
      table = table_of(model().mesh().triangles);
      break;
    case kEdges:
      table = table_of(edges = model().edges());
      break;
    case kPlaces:
      table = table_of(model().places());
      break;
    case kMeans:
      table = table_of(model().means());
      break;
    case kTerms:
      table = table_of(model().terms());
      break;
    case kCoefficients:
      table = table_of(model().coefficients());
      break;
    default:
      table = table_of(sheen::page::error());
  }
  return &table;
}

}  // extern "C"
