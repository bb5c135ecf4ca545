// SPDX-License-Identifier: Apache-2.0
// What the worker of a page for an irradiance field calls. One model; numbers and addresses of memory go in and out.
#include <emscripten.h>

#include <optional>

#include "reconstructor/page/wasm/exchange.h"
#include "reconstructor/page/wasm/relit_picture.h"

namespace {

enum TableName : std::uint32_t { kError, kScene, kLights, kPixels };

std::optional<sheen::RelitPicture>& picture() {
  static std::optional<sheen::RelitPicture> picture;
  return picture;
}

}  // namespace

extern "C" {

/// Room for so many bytes more of the file.
EMSCRIPTEN_KEEPALIVE char* sheen_more(std::uint32_t bytes) {
  return sheen::page::room_for(bytes);
}

/// 1 where the whole file was read, 0 before it is there.
EMSCRIPTEN_KEEPALIVE int sheen_read(int whole) {
  return sheen::page::tried([&] {
    if (whole == 0) return 0;
    picture().emplace(sheen::page::file(), "this model");
    sheen::page::file() = {};
    return 1;
  });
}

/// 0; then the table `kPixels` is the picture in that light.
EMSCRIPTEN_KEEPALIVE int sheen_light(double x, double y, double z) {
  return sheen::page::tried([&] {
    picture()->in_light({x, y, z});
    return 0;
  });
}

/// Address and length of a table, two numbers of 32 bits; until the next call.
EMSCRIPTEN_KEEPALIVE const sheen::page::Table* sheen_table(std::uint32_t name) {
  using sheen::page::table_of;
  static sheen::page::Table table;
  switch (name) {
    case kScene:
      table = table_of(picture()->scene());
      break;
    case kLights:
      table = table_of(picture()->lights());
      break;
    case kPixels:
      table = table_of(picture()->pixels());
      break;
    default:
      table = table_of(sheen::page::error());
  }
  return &table;
}

}  // extern "C"
