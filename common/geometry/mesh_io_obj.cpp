// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/mesh_io.h"

namespace sheen {

RawMesh read_obj(const std::string& path, std::string_view bytes) {
  MeshBuilder builder(path);
  WordReader reader(bytes, /*continuations=*/true);
  std::vector<std::string_view> words;
  std::vector<double> corners;
  while (reader.next(words)) {
    if (words[0] == "v") {
      double position[3];
      for (std::size_t i = 0; i < 3; ++i) {
        const auto value = words.size() > i + 1 ? parse_number(words[i + 1]) : std::nullopt;
        if (!value) builder.fail(reader.place(), "a vertex needs three numbers");
        position[i] = *value;
      }
      builder.add_vertex(position[0], position[1], position[2], reader.place());
    } else if (words[0] == "f") {
      corners.clear();
      for (std::size_t i = 1; i < words.size(); ++i) {
        // v, v/vt, v//vn or v/vt/vn; only the position counts here.
        const auto index = parse_number(words[i].substr(0, words[i].find('/')));
        if (!index || *index == 0)
          builder.fail(reader.place(), "\"" + std::string(words[i].substr(0, 40)) + "\" is not a corner of a face");
        // From 1 on, or backwards from the last vertex so far.
        const double corner = *index > 0 ? *index - 1 : static_cast<double>(builder.vertex_count()) + *index;
        if (corner < 0) builder.fail(reader.place(), "refers to a vertex before the first one");
        corners.push_back(corner);
      }
      builder.add_face(corners, reader.place());
    }
  }
  return builder.finish();
}

}  // namespace sheen
