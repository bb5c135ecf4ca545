// SPDX-License-Identifier: Apache-2.0
#include "common/link/wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "common/base/crc32c.h"
#include "common/base/errors.h"
#include "common/capture/capture_validation.h"
#include "common/link/wire_messages.h"
#include "tests/support/expect_same_bits.h"
#include "tests/support/sample_capture.h"

namespace sheen {
namespace {

using testing::expect_same_bits;
using ::testing::HasSubstr;
using testing::sample_capture;

constexpr PixelFormat kFormats[] = {PixelFormat::kMono8,    PixelFormat::kBayerRG8, PixelFormat::kBayerGR8,
                                    PixelFormat::kBayerGB8, PixelFormat::kBayerBG8, PixelFormat::kRGB8,
                                    PixelFormat::kRGB32f};
constexpr Codec kCodecs[] = {Codec::kRaw, Codec::kDeltaZstd};

Capture decode(const EncodedCapture& m) {
  return decode_capture(m.envelope, m.header, m.blob);
}

std::string refusal(const EncodedCapture& m) {
  try {
    decode(m);
  } catch (const ProtocolError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Wire, EveryFieldComesBackToTheLastBit) {
  for (const PixelFormat format : kFormats)
    for (const Codec codec : kCodecs)
      for (const std::size_t padding : {0, 5})
        for (const bool mask : {false, true}) {
          SCOPED_TRACE(pfnc_name(format));
          const Capture sent = sample_capture(format, 19, 7, padding, mask, 1);
          expect_same_bits(sent, decode(encode_capture(sent, MessageType::kKeep, codec)));
        }
}

TEST(Wire, ImagesNarrowerThanTheColourStepComeBack) {
  for (const PixelFormat format : kFormats)
    for (int width = 1; width <= 3; ++width) {
      const Capture sent = sample_capture(format, width, 1, 0, true, 2);
      expect_same_bits(sent, decode(encode_capture(sent, MessageType::kKeep, Codec::kDeltaZstd)));
    }
}

TEST(Wire, ADefaultPoseLightAndFisheyeComeBack) {
  Capture sent = sample_capture(PixelFormat::kRGB8, 4, 4, 0, false, 3);
  sent.pose = {};
  sent.light = {};
  sent.tags.clear();
  sent.camera.lens = LensModel::kFisheye;
  sent.sequence = 0;
  sent.verdict = FrameVerdict::kNoPose;
  expect_same_bits(sent, decode(encode_capture(sent, MessageType::kLive, Codec::kRaw)));
}

TEST(Wire, DeltaOfAGradientInEachColourSiteIsSmall) {
  Capture sent = sample_capture(PixelFormat::kBayerRG8, 512, 64, 0, false, 4);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 512; ++x)
      sent.image.bytes[y * 512 + x] = static_cast<std::uint8_t>((x % 2 ? 90 : 10) + x / 4 + y);
  const std::size_t raw = encode_capture(sent, MessageType::kKeep, Codec::kRaw).blob.size();
  EXPECT_LT(encode_capture(sent, MessageType::kKeep, Codec::kDeltaZstd).blob.size(), raw / 20);
}

/// Each edit breaks one field; the error must name it, on either side of the wire.
TEST(Wire, EveryFieldIsValidatedAndNamed) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  const std::pair<const char*, std::function<void(Capture&)>> edits[] = {
      {"source_session", [](Capture& c) { c.source_session.clear(); }},
      {"source_session", [](Capture& c) { c.source_session = std::string(129, 'x'); }},
      {"source_session", [](Capture& c) { c.source_session = "a\nb"; }},
      {"sequence", [](Capture& c) { c.sequence = 0; }},
      {"sequence", [](Capture& c) { c.sequence = 1ull << 63; }},
      {"name", [](Capture& c) { c.name = "\xC3\x28"; }},
      {"name", [](Capture& c) { c.name = std::string(1025, 'n'); }},
      {"calibration_hash", [](Capture& c) { c.calibration_hash = std::string(200, '0'); }},
      {"stage_hash", [](Capture& c) { c.stage_hash = std::string(1, '\0'); }},
      {"camera.fx", [](Capture& c) { c.camera.fx = 0; }},
      {"camera.cx", [=](Capture& c) { c.camera.cx = kNan; }},
      {"camera.distortion", [=](Capture& c) { c.camera.distortion[4] = kInf; }},
      {"camera", [](Capture& c) { c.camera.width += 1; }},
      {"camera.lens", [](Capture& c) { c.camera.lens = static_cast<LensModel>(7); }},
      {"image.format", [](Capture& c) { c.image.format = PixelFormat::kUnspecified; }},
      {"image.transfer", [](Capture& c) { c.image.transfer = Transfer::kUnspecified; }},
      {"image.width", [](Capture& c) { c.image.width = 0; }},
      {"image.stride", [](Capture& c) { c.image.stride = 3; }},
      {"image.bytes", [](Capture& c) { c.image.bytes.pop_back(); }},
      {"mask", [](Capture& c) { c.mask = ImageU8(3, 3, 1); }},
      {"mask", [](Capture& c) { c.mask = ImageU8(8, 4, 3); }},
      {"exposure.exposure_s", [](Capture& c) { c.exposure.exposure_s = -1; }},
      {"exposure.gain_db", [=](Capture& c) { c.exposure.gain_db = kNan; }},
      {"exposure.white_balance", [](Capture& c) { c.exposure.white_balance[1] = -1; }},
      {"exposure.black_level", [](Capture& c) { c.exposure.black_level = 1; }},
      {"photometry.response", [](Capture& c) { c.photometry->response[9] = -0.1f; }},
      {"photometry.response", [](Capture& c) { std::swap(c.photometry->response[90], c.photometry->response[91]); }},
      {"photometry.response", [](Capture& c) { c.photometry->response[255] = 0.9f; }},
      {"photometry.vignette", [=](Capture& c) { c.photometry->vignette.k[1] = kNan; }},
      {"photometry.vignette",
       [](Capture& c) {
         c.photometry->vignette.k = {-1.2, 0, 0};
       }},
      {"photometry.vignette_centre", [=](Capture& c) { c.photometry->vignette.cx = kInf; }},
      {"photometry.white_balance", [](Capture& c) { c.photometry->white_balance[2] = 0; }},
      {"photometry.saturation", [](Capture& c) { c.photometry->saturation = 1.01f; }},
      {"pose.status", [](Capture& c) { c.pose.status = static_cast<PoseStatus>(6); }},
      {"pose.rotation", [](Capture& c) { c.pose.camera_from_object.rotation.coeffs() *= 1.001; }},
      {"pose.rotation", [=](Capture& c) { c.pose.camera_from_object.rotation.x() = kNan; }},
      {"pose.translation", [=](Capture& c) { c.pose.camera_from_object.translation.y() = -kInf; }},
      {"pose.covariance", [=](Capture& c) { c.pose.covariance(2, 3) = kNan; }},
      {"pose.covariance", [](Capture& c) { c.pose.covariance(1, 1) = -1e-9; }},
      {"pose.covariance", [](Capture& c) { c.pose.covariance(0, 5) += 1e-8; }},
      {"pose.covariance", [](Capture& c) { c.pose.covariance(0, 5) = c.pose.covariance(5, 0) = 1; }},
      {"pose.reprojection_rms_px", [](Capture& c) { c.pose.reprojection_rms_px = -0.1; }},
      {"pose.blur_px", [=](Capture& c) { c.pose.blur_px = kInf; }},
      {"pose.tags_used", [](Capture& c) { c.pose.tags_used = -1; }},
      {"tags", [](Capture& c) { c.tags.resize(4097, c.tags[0]); }},
      {"tags.id", [](Capture& c) { c.tags[1].id = -1; }},
      {"tags.corners", [=](Capture& c) { c.tags[1].corners[3].y() = kNan; }},
      {"tags.residual_px", [=](Capture& c) { c.tags[0].residual_px = kNan; }},
      {"light.kind", [](Capture& c) { c.light.kind = static_cast<LightKind>(5); }},
      {"light.position", [=](Capture& c) { c.light.position.x() = kInf; }},
      {"light.position", [](Capture& c) { c.light = {LightKind::kDirectional, {0, 0, 2}, {1, 1, 1}}; }},
      {"light.rgb", [](Capture& c) { c.light.rgb[0] = -1; }},
      {"verdict", [](Capture& c) { c.verdict = static_cast<FrameVerdict>(10); }},
      {"purpose", [](Capture& c) { c.purpose = static_cast<Purpose>(3); }},
  };
  for (const auto& [field, edit] : edits) {
    Capture capture = sample_capture(PixelFormat::kMono8, 8, 4, 0, false, 5);
    edit(capture);
    try {
      encode_capture(capture, MessageType::kKeep, Codec::kRaw);
      ADD_FAILURE() << field << " was accepted";
    } catch (const ProtocolError& error) {
      EXPECT_THAT(error.what(), ::testing::StartsWith(field));
    }
  }
}

TEST(Wire, EnvelopeIsRefusedByWhatIsWrongWithIt) {
  const EncodedCapture good = encode_capture(sample_capture("s", 1), MessageType::kKeep, Codec::kRaw);
  EncodedCapture m = good;
  m.envelope[4] = 7;
  EXPECT_THAT(refusal(m), ::testing::AllOf(HasSubstr("version 7"), HasSubstr("version 1")));
  m = good;
  m.envelope[0] = 'X';
  EXPECT_THAT(refusal(m), HasSubstr("envelope.magic"));
  m = good;
  m.envelope.pop_back();
  EXPECT_THAT(refusal(m), HasSubstr("envelope"));
  m = good;
  m.envelope[6] = static_cast<std::uint8_t>(MessageType::kHello);
  EXPECT_THAT(refusal(m), HasSubstr("envelope: message type"));
}

TEST(Wire, DamagedOrShortPixelsAreRefused) {
  for (const Codec codec : kCodecs) {
    const EncodedCapture good = encode_capture(sample_capture("s", 1), MessageType::kKeep, codec);
    EncodedCapture m = good;
    m.blob[m.blob.size() / 2] ^= 1;
    EXPECT_THAT(refusal(m), HasSubstr("blob.crc32c"));
    m = good;
    m.blob.pop_back();
    EXPECT_THAT(refusal(m), HasSubstr("blob.bytes"));
    m = good;
    m.blob.clear();
    EXPECT_THAT(refusal(m), HasSubstr("blob.bytes"));
    m = good;
    m.header.clear();
    EXPECT_NE(refusal(m), "accepted");
  }
}

/// A header may lie about everything at once: whatever comes out is a capture that passes validation, or an error.
TEST(Wire, RandomMutationsGiveACaptureOrAnError) {
  std::mt19937 random(6);
  int accepted = 0, refused = 0;
  for (int round = 0; round < 20'000; ++round) {
    static const EncodedCapture kMessages[] = {
        encode_capture(sample_capture(PixelFormat::kBayerGB8, 9, 5, 2, true, 1), MessageType::kKeep, Codec::kRaw),
        encode_capture(sample_capture(PixelFormat::kRGB8, 6, 5, 0, false, 2), MessageType::kLive, Codec::kDeltaZstd)};
    EncodedCapture m = kMessages[round % 2];
    auto& part = round % 8 == 0 ? m.envelope : round % 8 == 1 ? m.blob : m.header;
    for (unsigned edits = 1 + random() % 3; edits > 0 && !part.empty(); --edits) {
      const std::size_t at = random() % part.size();
      switch (random() % 4) {
        case 0:
          part[at] ^= static_cast<std::uint8_t>(1u << random() % 8);
          break;
        case 1:
          part[at] = static_cast<std::uint8_t>(random());
          break;
        case 2:
          part.erase(part.begin() + static_cast<long>(at));
          break;
        default:
          part.insert(part.begin() + static_cast<long>(at), static_cast<std::uint8_t>(random()));
      }
    }
    try {
      const Capture capture = decode(m);
      EXPECT_EQ(validation_error(capture), "");
      ++accepted;
    } catch (const ProtocolError&) {
      ++refused;
    }
  }
  EXPECT_GT(accepted, 100);  // the mutations must reach behind the parser
  EXPECT_GT(refused, 1000);
}

TEST(Wire, EveryPrefixOfAMessageIsRefused) {
  Capture capture = sample_capture("s", 1);
  const EncodedCapture good = encode_capture(capture, MessageType::kKeep, Codec::kRaw);
  capture.photometry.reset();
  const std::size_t before_photometry = encode_capture(capture, MessageType::kKeep, Codec::kRaw).header.size();
  for (std::size_t size = 0; size < good.header.size(); ++size) {
    EncodedCapture m = good;
    m.header.resize(size);
    const std::string why = refusal(m);
    if (why == "accepted") {  // only trailing optional fields may be missing, and none in part
      EXPECT_GT(size, before_photometry - 40);
      EXPECT_LE(size, before_photometry);
    }
  }
}

TEST(Crc32c, GivesThePublishedValues) {  // RFC 3720 appendix B.4, and the catalogue's check value
  std::vector<std::uint8_t> zeros(32, 0), ones(32, 0xFF), ascending(32);
  for (int i = 0; i < 32; ++i) ascending[i] = static_cast<std::uint8_t>(i);
  const std::string digits = "123456789";
  const std::span check(reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size());
  for (const auto& crc : {crc32c, crc32c_portable}) {
    EXPECT_EQ(crc(zeros, 0), 0x8A9136AAu);
    EXPECT_EQ(crc(ones, 0), 0x62A8AB43u);
    EXPECT_EQ(crc(ascending, 0), 0x46DD794Eu);
    EXPECT_EQ(crc(check, 0), 0xE3069283u);
    EXPECT_EQ(crc(check.subspan(4), crc(check.first(4), 0)), 0xE3069283u);
  }
}

TEST(Crc32c, InstructionAndTableAgreeOnEveryLength) {
  std::mt19937 random(7);
  std::vector<std::uint8_t> bytes(100);
  for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random());
  for (std::size_t n = 0; n <= bytes.size(); ++n)
    EXPECT_EQ(crc32c(std::span(bytes).first(n)), crc32c_portable(std::span(bytes).first(n)));
}

TEST(LinkMessages, ComeBackAsTheyWent) {
  const Hello hello = decode_hello(encode(Hello{"reconstructor", 2, {{"a", {3, 5}}, {"b", {0, 1}}}, -7}));
  EXPECT_EQ(hello.role, "reconstructor");
  EXPECT_EQ(hello.credits, 2u);
  ASSERT_EQ(hello.held.size(), 2u);
  EXPECT_EQ(hello.held.at("a").durable, 3u);
  EXPECT_EQ(hello.held.at("a").received, 5u);
  EXPECT_EQ(hello.clock_ns, -7);
  const Welcome welcome = decode_welcome(encode(Welcome{"a", 9, 1, 2}));
  EXPECT_EQ(welcome.source_session, "a");
  EXPECT_EQ(welcome.first_sequence, 9u);
  EXPECT_EQ(welcome.hello_clock_ns, 1);
  EXPECT_EQ(welcome.clock_ns, 2);
  EXPECT_EQ(welcome.frames.judged, 0u);
  const Welcome told = decode_welcome(encode(Welcome{"a", 9, 1, 2, {56, {{"motion_blur", 55}}, "too fast"}}));
  EXPECT_EQ(told.frames.judged, 56u);
  EXPECT_EQ(told.frames.refused.at("motion_blur"), 55u);
  EXPECT_EQ(told.frames.trouble, "too fast");
  EXPECT_EQ(told.motion, RigMotion{}) << "nothing was said";
  const RigMotion lamp{.camera = Motion::kStill, .light = Motion::kMoves};
  EXPECT_EQ(decode_welcome(encode(Welcome{.source_session = "a", .motion = lamp})).motion, lamp);
  EXPECT_EQ(decode_credit(encode(Credit{4})).captures, 4u);
  const Ack ack = decode_ack(encode(Ack{"a", 6, true}));
  EXPECT_EQ(ack.source_session, "a");
  EXPECT_EQ(ack.durable, 6u);
  EXPECT_TRUE(ack.end_seen);
  EXPECT_EQ(decode_refuse(encode(Refuse{"because"})).reason, "because");
  EXPECT_EQ(decode_end(encode(End{"a", 12})).last_sequence, 12u);
}

TEST(LinkMessages, NonsenseIsRefused) {
  EXPECT_THROW(decode_hello(encode(Hello{"reconstructor", 5000, {}, 0})), ProtocolError);
  EXPECT_THROW(decode_welcome(encode(Welcome{"", 1, 0, 0})), ProtocolError);
  EXPECT_THROW(decode_welcome(encode(Welcome{"a", 0, 0, 0})), ProtocolError);
  EXPECT_THROW(decode_welcome(encode(Welcome{"a", 1, 0, 0, {5, {{"too_near", 4}, {"no_pose", 2}}, ""}})),
               ProtocolError);
  EXPECT_THROW(decode_welcome(encode(Welcome{"a", 1, 0, 0, {5, {}, "\x1b[2J"}})), ProtocolError);
  EXPECT_THROW(decode_welcome(encode(Welcome{.source_session = "a", .motion = {.light = static_cast<Motion>(3)}})),
               ProtocolError);
  EXPECT_THROW(decode_refuse(encode(Refuse{"\x1b[2J"})), ProtocolError);
  const Bytes garbage(40, 0xFF);
  EXPECT_THROW(decode_ack(garbage), ProtocolError);
  EXPECT_THROW(decode_status(garbage), ProtocolError);
  EXPECT_THROW(decode_status({}), ProtocolError);
}

TEST(LinkMessages, AStatusComesBackAsItWent) {
  const Status sent{"tracker", "s", 5, 77, SourceState::kStale, "camera unplugged", {{"frame_rate_hz", 29.97}}, {1, 2}};
  const Status got = decode_status(encode_status(sent));
  EXPECT_EQ(got.role, sent.role);
  EXPECT_EQ(got.source_session, sent.source_session);
  EXPECT_EQ(got.sequence, sent.sequence);
  EXPECT_EQ(got.clock_ns, sent.clock_ns);
  EXPECT_EQ(got.state, sent.state);
  EXPECT_EQ(got.message, sent.message);
  EXPECT_EQ(got.gauges, sent.gauges);
  EXPECT_EQ(got.preview_jpeg, sent.preview_jpeg);
}

}  // namespace
}  // namespace sheen
