// SPDX-License-Identifier: Apache-2.0
#include "common/image/exr.h"

#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfEnvmapAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>
#include <thread>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/exr_attributes.h"

namespace sheen {

namespace {

constexpr std::string_view kNumbers[] = {"expTime", "isoSpeed", "aperture"};
constexpr const char* kChromaticities = "chromaticities";
constexpr const char *kEnvironment = "envmap", *kCube = "cube", *kLatLong = "latlong";
constexpr int kMaxSide = 1 << 20;

/// Threads that compress and decompress, one pool for the process.
int pool_threads() {
  static const int threads = [] {
    const int count = static_cast<int>(std::thread::hardware_concurrency());
    Imf::setGlobalThreadCount(count);
    return count;
  }();
  return threads;
}

bool is_number_attribute(const std::string& name) {
  return std::find(std::begin(kNumbers), std::end(kNumbers), name) != std::end(kNumbers);
}

Imf::Header header_of(const ExrPartInfo& part, int picture_width, int picture_height) {
  const int right = part.width - 1, bottom = part.height - 1;
  Imf::Header header(Imath::Box2i({0, 0}, {picture_width - 1, picture_height - 1}),
                     Imath::Box2i({part.left, part.top}, {part.left + right, part.top + bottom}));
  header.setName(part.name);
  header.setType(Imf::SCANLINEIMAGE);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const std::string& channel : part.channels)
    header.channels().insert(channel, Imf::Channel(part.precision == ExrPrecision::kHalf ? Imf::HALF : Imf::FLOAT));
  return header;
}

Imf::Chromaticities chromaticities(const std::string& text) {
  Imf::Chromaticities c;
  std::istringstream(text) >> c.red.x >> c.red.y >> c.green.x >> c.green.y >> c.blue.x >> c.blue.y >> c.white.x >>
      c.white.y;
  return c;
}

std::string in_words(const Imf::Chromaticities& c) {
  std::ostringstream text;
  for (const Imath::V2f& place : {c.red, c.green, c.blue, c.white}) text << place.x << ' ' << place.y << ' ';
  return text.str();
}

void add_attributes(const ExrAttributes& attributes, Imf::Header& header) {
  for (const auto& [name, text] : attributes)
    if (name == kEnvironment)
      header.insert(name, Imf::EnvmapAttribute(text == kCube ? Imf::ENVMAP_CUBE : Imf::ENVMAP_LATLONG));
    else if (name == kChromaticities)
      header.insert(name, Imf::ChromaticitiesAttribute(chromaticities(text)));
    else if (is_number_attribute(name))
      header.insert(name, Imf::FloatAttribute(std::strtof(text.c_str(), nullptr)));
    else
      header.insert(name, Imf::StringAttribute(text));
}

/// A slice whose pixel (left, top) is `data[channel]`.
template <typename T>
Imf::Slice slice(T* data, Imf::PixelType type, int channel, int width, int channels, int left, int top) {
  const std::ptrdiff_t x_stride = sizeof(T) * channels, y_stride = x_stride * width;
  char* base = reinterpret_cast<char*>(data + channel) - left * x_stride - top * y_stride;
  return Imf::Slice(type, base, x_stride, y_stride);
}

std::vector<half> to_half(const ImageF& image) {
  std::vector<half> out(image.size());
  std::transform(image.data(), image.data() + image.size(), out.begin(), [](float value) {
    return half(std::isfinite(value) ? std::clamp<float>(value, -HALF_MAX, HALF_MAX) : value);
  });
  return out;
}

void write_part(const ExrPartInfo& part, const ImageF& image, Imf::OutputPart out) {
  if (image.width() != part.width || image.height() != part.height || image.channels() != int(part.channels.size()))
    throw Error("part \"" + part.name + "\": its image is not of the size that was announced");
  std::vector<half> halves;
  if (part.precision == ExrPrecision::kHalf) halves = to_half(image);
  const int width = image.width(), channels = image.channels();
  Imf::FrameBuffer buffer;
  for (int c = 0; c < channels; ++c)
    buffer.insert(part.channels[c],
                  part.precision == ExrPrecision::kHalf
                      ? slice(halves.data(), Imf::HALF, c, width, channels, part.left, part.top)
                      : slice(const_cast<float*>(image.data()), Imf::FLOAT, c, width, channels, part.left, part.top));
  out.setFrameBuffer(buffer);
  out.writePixels(image.height());
}

void check_writable(const std::filesystem::path& path, const std::vector<ExrPartInfo>& parts) {
  if (parts.empty()) throw FileError(path.string(), "cannot be written: an EXR file needs a part");
  std::set<std::string> names;
  for (const ExrPartInfo& part : parts) {
    const auto fail = [&](const char* what) {
      throw FileError(path.string(), "cannot be written: part \"" + part.name + "\" " + what);
    };
    if (part.width < 1 || part.height < 1 || part.channels.empty()) fail("has no pixels");
    if (std::set(part.channels.begin(), part.channels.end()).size() != part.channels.size())
      fail("has two channels of one name");
    if (part.name.empty() || !names.insert(part.name).second) fail("needs a name of its own");
  }
}

/// R, G, B, A first, within their layer.
bool channel_before(const std::string& a, const std::string& b) {
  const auto key = [](const std::string& name) {
    const std::size_t dot = name.rfind('.');
    const std::size_t last = dot == std::string::npos ? 0 : dot + 1;
    const std::size_t rank = name.size() - last == 1 ? std::string_view("RGBA").find(name[last]) : std::string::npos;
    return std::tuple(name.substr(0, last), rank, name);
  };
  return key(a) < key(b);
}

/// Pixels of one compressed block, which the library makes room for whole, however few of them the part has.
double block_pixels(const Imf::Header& header, double width) {
  if (header.hasTileDescription()) return double(header.tileDescription().xSize) * header.tileDescription().ySize;
  switch (header.compression()) {
    case Imf::NO_COMPRESSION:
    case Imf::RLE_COMPRESSION:
    case Imf::ZIPS_COMPRESSION:
      return width;
    case Imf::ZIP_COMPRESSION:
    case Imf::PXR24_COMPRESSION:
      return 16 * width;
    case Imf::DWAB_COMPRESSION:
      return 256 * width;
    default:
      return 32 * width;
  }
}

ExrPartInfo info_of(const Imf::Header& header, const std::string& where) {
  ExrPartInfo part;
  part.name = header.hasName() ? header.name() : "";
  if (header.hasType() && Imf::isDeepData(header.type())) throw Error(where + " is deep; only flat parts can be read");

  part.precision = ExrPrecision::kHalf;
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
    if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
      throw Error(where + ", channel " + c.name() + ": is subsampled, which cannot be read");
    if (c.channel().type != Imf::HALF) part.precision = ExrPrecision::kFloat;
    part.channels.push_back(c.name());
  }
  if (part.channels.empty()) throw Error(where + " has no channel");
  std::sort(part.channels.begin(), part.channels.end(), channel_before);

  const Imath::Box2i window = header.dataWindow(), picture = header.displayWindow();
  const auto side = [&](int first, int last) {
    const std::int64_t size = std::int64_t(last) - first + 1;
    if (size < 1 || size > kMaxSide) throw Error(where + " claims a side of " + std::to_string(size) + " pixels");
    return static_cast<int>(size);
  };
  part.width = side(window.min.x, window.max.x);
  part.height = side(window.min.y, window.max.y);
  part.picture = {side(picture.min.x, picture.max.x), side(picture.min.y, picture.max.y)};
  const auto offset = [&](int first, int first_of_picture) {
    const std::int64_t from = std::int64_t(first) - first_of_picture;
    if (std::abs(from) > kMaxSide) throw Error(where + " lies " + std::to_string(from) + " pixels off its picture");
    return static_cast<int>(from);
  };
  part.left = offset(window.min.x, picture.min.x);
  part.top = offset(window.min.y, picture.min.y);
  return part;
}

std::string name_of_part(const Imf::MultiPartInputFile& file, int index) {
  const Imf::Header& header = file.header(index);
  const std::string name = header.hasName() ? header.name() : "";
  return "part " + std::to_string(index) + (name.empty() ? "" : " (\"" + name + "\")");
}

/// The pixels of the channels that `info` names.
ExrPart read_part(Imf::MultiPartInputFile& file, int index, const ExrPartInfo& info, std::uintmax_t file_bytes) {
  const Imf::Header& header = file.header(index);
  const std::string where = name_of_part(file, index);
  // No compression packs more densely than this, but for pictures too small to matter.
  const double pixels = std::max(double(info.width) * info.height, block_pixels(header, info.width));
  const double claimed = pixels * double(info.channels.size()) * sizeof(float);
  if (claimed > 64e6 + 2000.0 * double(file_bytes))
    throw Error(where + " claims " + std::to_string(info.width) + " x " + std::to_string(info.height) +
                " pixels, more than the file can hold");
  ExrPart part{.name = info.name,
               .channels = info.channels,
               .image = ImageF(info.width, info.height, int(info.channels.size())),
               .precision = info.precision,
               .left = info.left,
               .top = info.top,
               .picture = info.picture};

  const Imath::Box2i window = header.dataWindow();
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < part.channels.size(); ++c)
    buffer.insert(part.channels[c], slice(part.image.data(), Imf::FLOAT, int(c), info.width, part.image.channels(),
                                          window.min.x, window.min.y));
  try {
    Imf::InputPart in(file, index);
    in.setFrameBuffer(buffer);
    in.readPixels(window.min.y, window.max.y);
  } catch (const std::exception& error) {
    throw Error(where + ": " + error.what());
  }
  return part;
}

/// Opens the file for `use(file, its size in bytes)`; what goes wrong names it.
template <typename Use>
auto with_exr(const std::filesystem::path& path, Use use) {
  std::error_code missing;
  const std::uintmax_t bytes = std::filesystem::file_size(path, missing);
  if (missing) throw FileError(path.string(), "cannot be read: " + missing.message());
  try {
    check_exr_attributes(path);
    Imf::MultiPartInputFile in(path.c_str(), pool_threads(), /*reconstructChunkOffsetTable=*/false);
    return use(in, bytes);
  } catch (const FileError&) {
    throw;  // from `use`, which knows more
  } catch (const std::exception& error) {
    throw FileError(path.string(), std::string("cannot be read as OpenEXR: ") + error.what());
  }
}

std::string shortest_text(float value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

ExrAttributes read_attributes(const Imf::Header& header) {
  ExrAttributes attributes;
  for (auto a = header.begin(); a != header.end(); ++a) {
    const std::string name = a.name();
    if (name == "name" || name == "type") continue;
    if (const auto* map = dynamic_cast<const Imf::EnvmapAttribute*>(&a.attribute()))
      attributes[name] = map->value() == Imf::ENVMAP_CUBE ? kCube : kLatLong;
    else if (const auto* colours = dynamic_cast<const Imf::ChromaticitiesAttribute*>(&a.attribute()))
      attributes[name] = in_words(colours->value());
    else if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute()))
      attributes[name] = text->value();
    else if (const auto* number = dynamic_cast<const Imf::FloatAttribute*>(&a.attribute());
             number && is_number_attribute(name))
      attributes[name] = shortest_text(number->value());
  }
  return attributes;
}

}  // namespace

const ExrPart* ExrFile::find(const std::string& name) const {
  const auto found = std::find_if(parts.begin(), parts.end(), [&](const ExrPart& part) { return part.name == name; });
  return found == parts.end() ? nullptr : &*found;
}

void write_exr(const std::filesystem::path& path, const ExrFile& file) {
  std::vector<ExrPartInfo> parts;
  for (const ExrPart& part : file.parts)
    parts.push_back({part.name, part.channels, part.image.width(), part.image.height(), part.precision, part.left,
                     part.top, part.picture});
  write_exr(path, parts, file.attributes, [&](std::size_t i) { return file.parts[i].image; });
}

void write_exr(const std::filesystem::path& path, const std::vector<ExrPartInfo>& parts,
               const ExrAttributes& attributes, const std::function<ImageF(std::size_t)>& image) {
  check_writable(path, parts);
  // The picture's size is shared by all parts: that of part 0.
  const ExrPartInfo& first = parts[0];
  const int width = first.picture.width > 0 ? first.picture.width : first.left + first.width;
  const int height = first.picture.height > 0 ? first.picture.height : first.top + first.height;
  std::vector<Imf::Header> headers;
  for (const ExrPartInfo& part : parts) headers.push_back(header_of(part, width, height));
  add_attributes(attributes, headers[0]);
  write_file(path, [&](const std::filesystem::path& unfinished) {
    try {
      Imf::MultiPartOutputFile out(unfinished.c_str(), headers.data(), int(headers.size()),
                                   /*overrideSharedAttributes=*/false, pool_threads());
      for (std::size_t i = 0; i < parts.size(); ++i) write_part(parts[i], image(i), Imf::OutputPart(out, int(i)));
    } catch (const std::exception& error) {
      throw FileError(path.string(), std::string("cannot be written: ") + error.what());
    }
  });
}

void write_exr(const std::filesystem::path& path, const ImageF& image) {
  if (image.channels() != 1 && image.channels() != 3)
    throw FileError(path.string(), "cannot be written: an image of " + std::to_string(image.channels()) +
                                       " channels needs names for them");
  ExrFile file;
  file.parts.push_back({"beauty",
                        image.channels() == 3 ? std::vector<std::string>{"R", "G", "B"} : std::vector<std::string>{"Y"},
                        image, ExrPrecision::kFloat});
  write_exr(path, file);
}

ExrFile read_exr(const std::filesystem::path& path) {
  ExrFile file;
  file.attributes = read_exr(
      path, [](const std::string&) { return true; }, [&](ExrPart&& part) { file.parts.push_back(std::move(part)); });
  return file;
}

std::vector<ExrPartInfo> read_exr_parts(const std::filesystem::path& path) {
  return with_exr(path, [](const Imf::MultiPartInputFile& in, std::uintmax_t) {
    std::vector<ExrPartInfo> parts;
    for (int i = 0; i < in.parts(); ++i) parts.push_back(info_of(in.header(i), name_of_part(in, i)));
    return parts;
  });
}

ExrPart read_exr_channels(const std::filesystem::path& path, int part, const std::vector<std::string>& channels) {
  return with_exr(path, [&](Imf::MultiPartInputFile& in, std::uintmax_t bytes) {
    ExrPartInfo info = info_of(in.header(part), name_of_part(in, part));
    info.channels = channels;
    return read_part(in, part, info, bytes);
  });
}

ExrAttributes read_exr(const std::filesystem::path& path, const std::function<bool(const std::string& part)>& wanted,
                       const std::function<void(ExrPart&&)>& visit) {
  return with_exr(path, [&](Imf::MultiPartInputFile& in, std::uintmax_t bytes) {
    for (int i = 0; i < in.parts(); ++i)
      if (wanted(in.header(i).hasName() ? in.header(i).name() : ""))
        visit(read_part(in, i, info_of(in.header(i), name_of_part(in, i)), bytes));
    return read_attributes(in.header(0));
  });
}

}  // namespace sheen
