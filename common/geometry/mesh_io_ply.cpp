// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/length_limit.h"
#include "common/geometry/mesh_io.h"

namespace sheen {

namespace {

enum class Encoding { kAscii, kLittleEndian, kBigEndian };
enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

const std::map<std::string_view, Scalar> kScalars = {
    {"char", Scalar::kInt8},      {"int8", Scalar::kInt8},       {"uchar", Scalar::kUint8},
    {"uint8", Scalar::kUint8},    {"short", Scalar::kInt16},     {"int16", Scalar::kInt16},
    {"ushort", Scalar::kUint16},  {"uint16", Scalar::kUint16},   {"int", Scalar::kInt32},
    {"int32", Scalar::kInt32},    {"uint", Scalar::kUint32},     {"uint32", Scalar::kUint32},
    {"float", Scalar::kFloat32},  {"float32", Scalar::kFloat32}, {"double", Scalar::kFloat64},
    {"float64", Scalar::kFloat64}};

constexpr std::string_view kBlanks = " \t\r\n\v\f";

struct Property {
  std::string_view name;
  Scalar value;
  std::optional<Scalar> list_count;  ///< of a list: the type of its length
};

struct Element {
  std::string_view name;
  double count = 0;
  std::vector<Property> properties;
};

constexpr std::string_view kOrigin = "sheen_origin";  // of a comment

struct Header {
  Encoding encoding = Encoding::kAscii;
  std::optional<Eigen::Vector3d> origin;
  std::vector<Element> elements;
  std::string_view body;
};

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw FileError(path, what);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  WordReader(line, false).next(words);
  return words;
}

Property parse_property(const std::string& path, const std::vector<std::string_view>& words, std::size_t line) {
  const auto scalar = [&](std::string_view word) {
    const auto found = kScalars.find(word);
    if (found == kScalars.end())
      fail(path, "header line " + std::to_string(line) + ": unknown type \"" + std::string(word.substr(0, 40)) + "\"");
    return found->second;
  };
  if (words.size() == 5 && words[1] == "list") return {words[4], scalar(words[3]), scalar(words[2])};
  if (words.size() == 3) return {words[2], scalar(words[1]), std::nullopt};
  fail(path, "header line " + std::to_string(line) + ": a property is TYPE NAME or list TYPE TYPE NAME");
}

template <typename Bad>
Eigen::Vector3d parse_origin(const std::vector<std::string_view>& words, const Bad& bad) {
  Eigen::Vector3d origin;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value = words.size() == 5 ? parse_number(words[2 + k]) : std::nullopt;
    if (!value || !(std::abs(*value) <= kLongestLength)) bad("an origin is three numbers of at most 10^9 m");
    origin[static_cast<Eigen::Index>(k)] = *value;
  }
  return origin;
}

Header parse_header(const std::string& path, std::string_view bytes) {
  Header header;
  bool has_format = false;
  for (std::size_t line = 1;; ++line) {
    const std::size_t end = bytes.find('\n');
    if (end == std::string_view::npos) fail(path, "the header has no end_header");
    const auto words = split(bytes.substr(0, end));
    bytes.remove_prefix(end + 1);
    const auto bad = [&](const char* what) { fail(path, "header line " + std::to_string(line) + ": " + what); };
    if (words.size() >= 2 && words[0] == "comment" && words[1] == kOrigin) header.origin = parse_origin(words, bad);
    if (words.empty() || words[0] == "ply" || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() >= 2) {
      has_format = true;
      if (words[1] == "ascii") {
        header.encoding = Encoding::kAscii;
      } else if (words[1] == "binary_little_endian") {
        header.encoding = Encoding::kLittleEndian;
      } else if (words[1] == "binary_big_endian") {
        header.encoding = Encoding::kBigEndian;
      } else {
        bad("unknown format");
      }
    } else if (words[0] == "element" && words.size() == 3) {
      const auto count = parse_number(words[2]);
      if (!count || !(*count >= 0)) bad("an element needs a count");
      header.elements.push_back({words[1], *count, {}});
    } else if (words[0] == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(parse_property(path, words, line));
    } else {
      bad("is neither format, element, property nor comment");
    }
  }
  if (!has_format) fail(path, "the header has no format line");
  // Without a property an element takes no bytes, and its count would be believed without any.
  for (const Element& element : header.elements)
    if (element.properties.empty() && element.count > 0)
      fail(path, "element " + std::string(element.name) + " has no property");
  header.body = bytes;
  return header;
}

/// Lines that say something.
double count_lines(std::string_view text) {
  double lines = 0;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    if (line.find_first_not_of(kBlanks) != std::string_view::npos) ++lines;
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
  return lines;
}

/// Takes one number after the other from the body, in any of the encodings.
class BodyReader {
 public:
  explicit BodyReader(const Header& header) : encoding_(header.encoding), rest_(header.body) {
    double rows = 0;
    for (const Element& element : header.elements) rows += element.count;
    rows_are_lines_ = encoding_ == Encoding::kAscii && count_lines(rest_) >= rows;
  }

  /// Passes over numbers that the header does not know, where each row has a line of its own.
  void end_row() {
    if (rows_are_lines_) rest_.remove_prefix(std::min(rest_.find('\n'), rest_.size()));
  }

  /// Empty at the end of the file, and in ASCII for a word that is no number.
  std::optional<double> next(Scalar type) {
    if (encoding_ == Encoding::kAscii) return next_word();
    switch (type) {
      case Scalar::kInt8:
        return next_binary<std::int8_t>();
      case Scalar::kUint8:
        return next_binary<std::uint8_t>();
      case Scalar::kInt16:
        return next_binary<std::int16_t>();
      case Scalar::kUint16:
        return next_binary<std::uint16_t>();
      case Scalar::kInt32:
        return next_binary<std::int32_t>();
      case Scalar::kUint32:
        return next_binary<std::uint32_t>();
      case Scalar::kFloat32:
        return next_binary<float>();
      case Scalar::kFloat64:
        return next_binary<double>();
    }
    return std::nullopt;
  }

 private:
  std::optional<double> next_word() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kBlanks));
    rest_.remove_prefix(word.size());
    return parse_number(word);
  }

  template <typename T>
  std::optional<double> next_binary() {
    static_assert(std::endian::native == std::endian::little);
    if (rest_.size() < sizeof(T)) return std::nullopt;
    char bytes[sizeof(T)];
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bytes[i] = rest_[encoding_ == Encoding::kBigEndian ? sizeof(T) - 1 - i : i];
    rest_.remove_prefix(sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return static_cast<double>(value);
  }

  Encoding encoding_;
  std::string_view rest_;
  bool rows_are_lines_ = false;
};

int coordinate_axis(const Property& property) {
  if (property.list_count) return -1;
  return property.name == "x" ? 0 : property.name == "y" ? 1 : property.name == "z" ? 2 : -1;
}

constexpr std::string_view kEvidence = "evidence";  // `ShapeEvidence` of a vertex

bool is_evidence(const Property& property) {
  return !property.list_count && property.name == kEvidence && property.value == Scalar::kUint8;
}

bool holds_corners(const Property& property) {
  return property.list_count && (property.name == "vertex_indices" || property.name == "vertex_index");
}

}  // namespace

RawMesh read_ply(const std::string& path, std::string_view bytes) {
  const Header header = parse_header(path, bytes);
  BodyReader body(header);
  MeshBuilder builder(path);
  if (header.origin) builder.set_origin(*header.origin);
  std::vector<double> list;
  std::vector<ShapeEvidence> evidence;
  for (const Element& element : header.elements) {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    const bool is_strips = element.name == "tristrips";
    if (is_vertex) {
      bool axes[3] = {};
      for (const Property& property : element.properties)
        if (coordinate_axis(property) >= 0) axes[coordinate_axis(property)] = true;
      if (!axes[0] || !axes[1] || !axes[2]) fail(path, "element vertex lacks one of the properties x, y, z");
    }
    if (is_face && element.count > 0 &&
        std::none_of(element.properties.begin(), element.properties.end(), holds_corners))
      fail(path, "holds no triangle: element face has no list vertex_indices (or vertex_index)");
    // The count is only ever a limit: memory grows with what really stands in the file.
    for (std::size_t i = 0; static_cast<double>(i) < element.count; ++i) {
      const FilePlace place{is_vertex ? "vertex" : is_face ? "face" : "row", i};
      const auto next = [&](const Property& property, Scalar type) {
        const auto value = body.next(type);
        if (!value)
          builder.fail(place, "element " + std::string(element.name) + ", property " + std::string(property.name) +
                                  ": no number (is the file cut off?)");
        return *value;
      };
      double position[3] = {};
      for (const Property& property : element.properties) {
        if (property.list_count) {
          const double count = next(property, *property.list_count);
          if (!(count >= 0)) builder.fail(place, "property " + std::string(property.name) + ": negative length");
          list.clear();
          for (double k = 0; k < count; ++k) list.push_back(next(property, property.value));
          if (is_face && holds_corners(property)) builder.add_face(list, place);
          if (is_strips && holds_corners(property)) builder.add_strips(list, place);
        } else {
          const double value = next(property, property.value);
          if (const int axis = coordinate_axis(property); axis >= 0) position[axis] = value;
          if (is_vertex && is_evidence(property) && value <= double(ShapeEvidence::kSeen))
            evidence.push_back(static_cast<ShapeEvidence>(value));
        }
      }
      if (is_vertex) builder.add_vertex(position[0], position[1], position[2], place);
      body.end_row();
    }
  }
  RawMesh mesh = builder.finish();
  if (evidence.size() == mesh.vertices.size()) mesh.evidence = std::move(evidence);  // else it is another program's
  return mesh;
}

void save_ply(const Mesh& mesh, const std::filesystem::path& path) {
  save_ply(mesh, path, {});
}

void save_ply(const Mesh& mesh, const std::filesystem::path& path, std::span<const VertexValues> values,
              const std::string& comment) {
  const bool far = mesh.origin != Eigen::Vector3d::Zero();
  const std::string number = far ? "double" : "float";
  const bool known = !mesh.evidence.empty();
  std::string out = "ply\nformat binary_little_endian 1.0\n";
  if (far)
    out += format("comment %s %.17g %.17g %.17g\n", kOrigin.data(), mesh.origin.x(), mesh.origin.y(), mesh.origin.z());
  if (!comment.empty()) out += "comment " + comment + '\n';
  out += "element vertex " + std::to_string(mesh.vertices.size());
  for (const char* axis : {"x", "y", "z"}) out += "\nproperty " + number + ' ' + axis;
  out += '\n';
  for (const VertexValues& v : values) out += (v.bytes ? "property uchar " : "property float ") + v.name + '\n';
  if (known) out += "property uchar " + std::string(kEvidence) + '\n';
  out += "element face " + std::to_string(mesh.triangles.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
  out.reserve(out.size() + ((far ? 24 : 12) + 4 * values.size() + 1) * mesh.vertices.size() +
              13 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d in_file = mesh.vertices[i].cast<double>() + mesh.origin;
    if (far)
      out.append(reinterpret_cast<const char*>(in_file.data()), 24);
    else
      out.append(reinterpret_cast<const char*>(mesh.vertices[i].data()), 12);
    for (const VertexValues& v : values) {
      if (v.bytes)
        out.push_back(static_cast<char>(std::lround(std::clamp(v.values[i], 0.0f, 255.0f))));
      else
        out.append(reinterpret_cast<const char*>(&v.values[i]), 4);
    }
    if (known) out.push_back(static_cast<char>(mesh.evidence[i]));
  }
  for (const Triangle& triangle : mesh.triangles) {
    out.push_back(3);
    out.append(reinterpret_cast<const char*>(triangle.data()), 12);
  }
  write_file(path, out);
}

}  // namespace sheen
