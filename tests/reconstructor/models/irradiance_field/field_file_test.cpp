// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/field_file.h"
#include "reconstructor/irradiance_field_file/encode/field_encoding.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "common/base/files.h"
#include "reconstructor/models/irradiance_field/compress.h"
#include "tests/reconstructor/models/irradiance_field/lambertian_relief.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

const LightState kLight{.kind = LightKind::kDirectional, .position = {0.3, -0.2, 0.9}};

class FieldFileTest : public ::testing::Test {
 protected:
  std::shared_ptr<const IrradianceFieldSnapshot> compressed(const CompressionTarget& target) const {
    return std::dynamic_pointer_cast<const IrradianceFieldSnapshot>(exact_->compressed(target).snapshot);
  }
  static std::string bytes_of(const IrradianceFieldSnapshot& field) {
    return encode_field(field.scene(), field.field());
  }
  /// Where each chunk ends.
  static std::vector<std::size_t> chunk_ends(const std::string& bytes) {
    std::vector<std::size_t> ends;
    for (std::size_t at = 12; at < bytes.size();) {
      std::uint64_t size = 0;
      std::memcpy(&size, bytes.data() + at + 8, sizeof size);
      at += 16 + size;
      ends.push_back(at);
    }
    return ends;
  }

  const TempFolder temp_;
  const LambertianRelief relief_{.width = 130, .height = 100, .tilt = 0.3};
  const std::shared_ptr<const IrradianceFieldSnapshot> exact_ =
      std::dynamic_pointer_cast<const IrradianceFieldSnapshot>(relief_.model(dome_of_lights())->snapshot());
};

TEST_F(FieldFileTest, AReopenedFileIsTheSameToTheBit) {
  const auto small = compressed({.bytes = 12000});
  const auto file = temp_.path() / "field";
  small->save(file, {{"source", "a test"}}, {});
  const auto again = load_field(file);
  EXPECT_EQ(again->picture(kLight), small->picture(kLight));
  EXPECT_EQ(again->picture({}), small->picture({}));
  EXPECT_EQ(field_file_metadata(file).at("source"), "a test");
  EXPECT_EQ(again->scene().kernel, small->scene().kernel);
  EXPECT_EQ(again->scene().error, small->scene().error);
}

TEST_F(FieldFileTest, AReopenedFolderIsTheSameToTheBit) {
  exact_->save(temp_.path() / "model", {}, {});
  EXPECT_EQ(load_field(temp_.path() / "model")->picture(kLight), exact_->picture(kLight));
}

TEST_F(FieldFileTest, NotesAreReplacedAndNothingElse) {
  const auto file = temp_.path() / "field";
  compressed({.bytes = 12000})->save(file, {}, {});
  const auto picture = load_field(file)->picture(kLight);
  save_field_file(file, read_file(file), {{"held_out_psnr_db", "40"}});
  EXPECT_EQ(field_file_metadata(file).at("held_out_psnr_db"), "40");
  EXPECT_EQ(load_field(file)->picture(kLight), picture);
}

TEST_F(FieldFileTest, KeepsToItsBytes) {
  for (const double bytes : {9000.0, 14000.0, 20000.0}) {
    const auto small = compressed({.bytes = bytes});
    const auto file = temp_.path() / "field";
    small->save(file, {{"source", std::string(1500, 'x')}}, {});
    const auto size = static_cast<double>(std::filesystem::file_size(file));
    EXPECT_LE(size, bytes);
    EXPECT_GE(size + 2000, 0.98 * bytes) << "the notes may take 2000";
  }
  expect_error<ConfigError>([&] { compressed({.bytes = 1000}); }, {"does not fit into 1000 bytes", "least"});
}

TEST_F(FieldFileTest, TakesNoBytesThatSayNothing) {
  const auto small = compressed({.bytes = 1e9});
  EXPECT_FLOAT_EQ(small->field().step, kFinestStep);
}

TEST_F(FieldFileTest, LosesAsMuchAsItIsAskedTo) {
  for (const double loss : {0.05, 0.3}) {
    const CompressedModel small = exact_->compressed({.loss_db = loss});
    EXPECT_LE(small.loss_db, loss);
    EXPECT_GT(small.loss_db, 0.7 * loss);
  }
}

TEST_F(FieldFileTest, DamageIsFoundByItsChunk) {
  const std::string bytes = bytes_of(*compressed({.bytes = 12000}));
  std::size_t begin = 12;
  for (const std::size_t end : chunk_ends(bytes)) {
    std::string damaged = bytes;
    damaged[(begin + 16 + end) / 2] ^= 0x10;
    expect_error([&] { decode_field(damaged, "field", true); }, {"\"" + bytes.substr(begin, 4) + "\" is damaged"});
    begin = end;
  }
}

TEST_F(FieldFileTest, AFileThatIsCutShortIsRefused) {
  const std::string bytes = bytes_of(*compressed({.bytes = 12000}));
  for (std::size_t size = 0; size < bytes.size(); size += size < 64 ? 1 : 97)
    EXPECT_THROW(decode_field(std::string_view(bytes).substr(0, size), "field", true), FileError) << size;
  expect_error([&] { decode_field("sheenSLF" + bytes.substr(8), "field", true); },
               {"is not a file of the kind irradiance field"});
  std::string other = bytes;
  other[8] = 9;
  expect_error([&] { decode_field(other, "field", true); }, {"version 9"});
}

/// Chunks of which the checksum is right: what they say must still make sense.
TEST_F(FieldFileTest, LiesAreRefusedOrHarmless) {
  std::mt19937 random(3);
  const QuantisedField honest = compressed({.bytes = 12000})->field();
  const std::string map = encode_component(honest, 0);
  for (int trial = 0; trial < 300; ++trial) {
    std::string lie = map;
    for (int flips = 0; flips < 8; ++flips) lie[random() % lie.size()] = static_cast<char>(random());
    if (trial % 3 == 0) lie.resize(random() % lie.size());
    QuantisedField field{.size = honest.size, .lights = honest.lights, .step = honest.step};
    field.components[0].bits.resize(honest.components[0].terms());
    try {
      decode_component(lie, field, 0);
      const FieldTerms terms = dequantise(field);
      EXPECT_TRUE(terms.components[0].coefs.allFinite());
    } catch (const std::runtime_error&) {
    }
  }
}

}  // namespace
}  // namespace sheen
