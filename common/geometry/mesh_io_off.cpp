// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/mesh_io.h"

namespace sheen {

RawMesh read_off(const std::string& path, std::string_view bytes) {
  MeshBuilder builder(path);
  WordReader reader(bytes, /*continuations=*/false);
  std::vector<std::string_view> words;
  const auto next_line = [&](const char* what) {
    if (!reader.next(words)) builder.fail(reader.place(), std::string("the file ends where ") + what + " should stand");
  };
  const auto number = [&](std::size_t i, const char* what) {
    const auto value = i < words.size() ? parse_number(words[i]) : std::nullopt;
    if (!value) builder.fail(reader.place(), std::string("is not ") + what);
    return *value;
  };

  next_line("the counts");
  // The word is optional; letters before it announce more numbers behind the position, and some write the first count
  // against it.
  if (const std::size_t off = words[0].find("OFF"); off != std::string_view::npos) {
    const std::string_view variant = words[0].substr(0, off);
    words[0].remove_prefix(off + 3);
    if (words[0].empty()) words.erase(words.begin());
    if (variant.find_first_of("4n") != std::string_view::npos || (!words.empty() && words[0] == "BINARY"))
      builder.fail(reader.place(), "this variant of OFF cannot be read; write ASCII OFF of three coordinates");
    if (words.empty()) next_line("the counts");
  }
  const double vertices = number(0, "a count of vertices"), faces = number(1, "a count of faces");
  for (double v = 0; v < vertices; ++v) {
    next_line("a vertex");
    const double x = number(0, "a vertex"), y = number(1, "a vertex"), z = number(2, "a vertex");
    builder.add_vertex(x, y, z, reader.place());
  }
  std::vector<double> corners;
  for (double f = 0; f < faces; ++f) {
    next_line("a face");
    const double count = number(0, "a face");
    corners.clear();
    for (std::size_t i = 1; static_cast<double>(i) <= count; ++i) corners.push_back(number(i, "a face"));
    builder.add_face(corners, reader.place());
  }
  return builder.finish();
}

}  // namespace sheen
