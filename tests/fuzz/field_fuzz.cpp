// SPDX-License-Identifier: Apache-2.0
// Whatever an irradiance field's file holds, its checksums right or wrong: a model that can be relit and written again
// to the same bits, or a FileError.
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "common/base/errors.h"
#include "reconstructor/coding/chunk_file.h"
#include "reconstructor/irradiance_field_file/encode/field_encoding.h"
#include "reconstructor/models/irradiance_field/field_file.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/reconstructor/models/irradiance_field/lambertian_relief.h"

namespace {

using namespace sheen;
using fuzz::Input;

std::string valid_file() {
  const LambertianRelief relief{.width = 20, .height = 18};
  const auto model = relief.model({{0, 0, 1}, {0.5, 0, 1}, {-0.4, 0.3, 1}, {0.1, -0.6, 1}, {0.6, 0.6, 1}});
  const auto exact = std::dynamic_pointer_cast<const IrradianceFieldSnapshot>(model->snapshot());
  return encode_field(exact->scene(), exact->field());
}

constexpr std::size_t kStart = 12, kHead = 16;

struct Chunk {
  std::string name, bytes;
};

std::vector<Chunk> chunks_of(const std::string& file) {
  std::vector<Chunk> chunks;
  for (std::size_t at = kStart; at < file.size();) {
    std::uint64_t size = 0;
    std::memcpy(&size, file.data() + at + 8, sizeof size);
    chunks.push_back({file.substr(at, 4), file.substr(at + kHead, size)});
    at += kHead + size;
  }
  return chunks;
}

std::string joined(const std::string& start, const std::vector<Chunk>& chunks) {
  std::string file = start;
  for (const Chunk& chunk : chunks) append_chunk(file, chunk.name, chunk.bytes);
  return file;
}

/// Damages what a chunk holds: its text where it is packed.
void damage(Chunk& chunk, Input& in) {
  const bool is_text = chunk.name == "DESC";
  std::string contents = is_text ? unpacked(chunk.bytes) : chunk.bytes;
  for (int times = 1 + in.byte() % 8; times > 0; --times) fuzz::damage_once(contents, in);
  chunk.bytes = is_text ? packed(contents) : contents;
}

void look_at(const IrradianceFieldSnapshot& field) {
  for (const Eigen::Vector3d& from : {Eigen::Vector3d(0.2, 0.1, 1), {0, 0, 0.3}, {-0.5, 0.4, 0.2}}) {
    const ImageU8 picture = field.screen_picture({.kind = field.light_kind(), .position = from});
    fuzz::demand(picture.width() == field.field().size.width, "a picture of another size");
  }
  field.picture({});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string kValid = valid_file();
  Input in{{data, size}};
  std::vector<Chunk> chunks = chunks_of(kValid);
  std::string file = kValid;
  if (in.byte() % 8 != 0) {
    while (in.rest.size() >= 6) damage(chunks[in.byte() % chunks.size()], in);
    file = joined(kValid.substr(0, kStart), chunks);
  } else {
    while (in.rest.size() >= 4) fuzz::damage_once(file, in);
  }
  try {
    const auto field = decode_field(file, "fuzzed", true);
    if (field->field().size.width > 2000 || field->field().size.height > 2000) return 0;  // slow
    look_at(*field);
    const std::string once = encode_field(field->scene(), field->field());
    const auto again = decode_field(once, "again", true);
    fuzz::demand(encode_field(again->scene(), again->field()) == once, "other bits when read again");
  } catch (const FileError&) {
  }
  return 0;
}
