// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/log.h"
#include "common/link/transport.h"
#include "tests/support/expect_error.h"
#include "tests/support/link.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using namespace std::chrono_literals;
using testing::eventually;
using testing::expect_kept;
using ::testing::HasSubstr;
using testing::keep;
using testing::kLong;
using testing::receiver_options;
using testing::sender_options;

class Curve : public ::testing::Test {
 protected:
  CurveKeys make(const std::string& name) { return generate_keys(temp_.path(), name); }
  void allow(const std::string& lines) { temp_.write("allowed", lines); }
  SenderOptions sender() {
    SenderOptions options = sender_options();
    options.keys = tracker_;
    options.allowlist = temp_.path() / "allowed";
    return options;
  }
  ReceiverOptions receiver(const CaptureSender& sender, const CurveKeys& keys) {
    ReceiverOptions options = receiver_options(sender.endpoint());
    options.keys = keys;
    options.server_public_key = tracker_.public_key;
    return options;
  }
  static std::string line(const CurveKeys& keys, const std::string& role = "reconstructor") {
    return keys.public_key + " " + role + " somebody\n";
  }

  TempFolder temp_;
  CurveKeys tracker_ = make("tracker"), desk_ = make("desk"), stranger_ = make("stranger");
};

TEST_F(Curve, AnAllowedKeyGetsTheData) {
  allow("# who may connect\n\n" + line(desk_) + line(stranger_, "monitor"));
  CaptureSender tracker(sender());
  CaptureReceiver desk(receiver(tracker, desk_));
  keep(tracker, 1, 20);
  expect_kept(desk, 1, 20);
  EXPECT_TRUE(tracker.finish(kLong));
  EXPECT_EQ(tracker.stats().refused_keys, 0u);
}

TEST_F(Curve, AWrongKeyGetsNothingIsCountedAndTheLiveLinkGoesOn) {
  allow(line(desk_));
  CaptureSender tracker(sender());
  CaptureReceiver desk(receiver(tracker, desk_));
  keep(tracker, 1, 3);
  expect_kept(desk, 1, 3);
  CaptureReceiver stranger(receiver(tracker, stranger_));
  ASSERT_TRUE(eventually([&] { return tracker.stats().refused_keys > 0; }));
  EXPECT_THAT(tracker.stats().last_refusal, HasSubstr(stranger_.public_key));
  ASSERT_TRUE(eventually([&] { return !stranger.stats().last_error.empty(); }));
  EXPECT_THAT(stranger.stats().last_error, HasSubstr("allowlist"));
  keep(tracker, 4, 8);
  expect_kept(desk, 4, 8);
  EXPECT_FALSE(stranger.next(50ms));
  EXPECT_EQ(stranger.stats().bytes, 0u);
  EXPECT_FALSE(stranger.stats().connected);
  EXPECT_TRUE(tracker.stats().peer_connected);
}

bool stands_in(const std::filesystem::path& log, const std::string& words) {
  return eventually([&] { return std::filesystem::exists(log) && read_file(log).find(words) != std::string::npos; });
}

TEST_F(Curve, ARefusedKeyIsLoggedOnceByTheSideThatRefusesNamingKeyAndRole) {
  const std::filesystem::path log = temp_.path() / "log";
  start_logging({.file = log});
  allow(line(desk_, "monitor"));
  {
    CaptureSender tracker(sender());
    CaptureReceiver stranger(receiver(tracker, stranger_));
    EXPECT_TRUE(stands_in(log, "key " + stranger_.public_key + " is not in the allowlist"));
    CaptureReceiver desk(receiver(tracker, desk_));
    EXPECT_TRUE(stands_in(log, "key " + desk_.public_key + " (somebody) has role monitor"));
    ASSERT_TRUE(eventually([&] { return tracker.stats().refused_keys >= 6; }));  // they keep trying
  }
  stop_logging();
  const std::string text = read_file(log);
  for (const CurveKeys& key : {stranger_, desk_}) {
    const std::size_t first = text.find(key.public_key);
    EXPECT_EQ(text.find(key.public_key, first + 1), std::string::npos) << "one line per minute is enough";
  }
}

TEST_F(Curve, AConnectionThatSaysNothingOrNonsenseIsNoRefusedKey) {
  allow(line(desk_));
  CaptureSender tracker(sender());
  const std::string endpoint = tracker.endpoint();
  const auto port = static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1)));
  for (const std::string& said : {std::string(), std::string("GET / HTTP/1.0\r\n\r\n"), std::string(200, '\0')}) {
    const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{.sin_family = AF_INET, .sin_port = htons(port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    ASSERT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::send(fd, said.data(), said.size(), MSG_NOSIGNAL), static_cast<ssize_t>(said.size()));
    std::this_thread::sleep_for(50ms);
    ::close(fd);
  }
  EXPECT_TRUE(eventually([&] { return tracker.stats().broken_handshakes >= 1; }));
  EXPECT_EQ(tracker.stats().refused_keys, 0u);
  CaptureReceiver desk(receiver(tracker, desk_));
  keep(tracker, 1, 2);
  expect_kept(desk, 1, 2);
}

TEST_F(Curve, AKeyOfAnotherRoleGetsNothing) {
  allow(line(desk_, "monitor"));
  CaptureSender tracker(sender());
  CaptureReceiver desk(receiver(tracker, desk_));
  keep(tracker, 1, 1);
  ASSERT_TRUE(eventually([&] { return tracker.stats().refused_keys > 0; }));
  EXPECT_THAT(tracker.stats().last_refusal, HasSubstr("role monitor"));
  EXPECT_FALSE(desk.next(50ms));
}

TEST_F(Curve, WithoutKeysOrWithAnotherServersKeyThereIsNoLink) {
  allow(line(desk_));
  CaptureSender tracker(sender());
  keep(tracker, 1, 1);
  CaptureReceiver plain(receiver_options(tracker.endpoint()));
  ReceiverOptions deceived = receiver(tracker, desk_);
  deceived.server_public_key = stranger_.public_key;
  CaptureReceiver other(deceived);
  ASSERT_TRUE(eventually([&] { return tracker.stats().refused_keys >= 2; }));
  EXPECT_FALSE(plain.next(50ms));
  EXPECT_FALSE(other.next(50ms));
  EXPECT_EQ(plain.stats().bytes + other.stats().bytes, 0u);
  ASSERT_TRUE(eventually([&] { return !other.stats().last_error.empty(); }));
  EXPECT_THAT(other.stats().last_error, HasSubstr("handshake"));
}

TEST_F(Curve, TheAllowlistIsReadAgainWhenItChanges) {
  allow("");
  CaptureSender tracker(sender());
  CaptureReceiver desk(receiver(tracker, desk_));
  keep(tracker, 1, 2);
  ASSERT_TRUE(eventually([&] { return tracker.stats().refused_keys > 0; }));
  allow(line(desk_));
  expect_kept(desk, 1, 2);
  allow("# nobody any more\n");  // also ends a link that is up
  ASSERT_TRUE(eventually([&] { return !tracker.stats().peer_connected; }));
  keep(tracker, 3, 3);
  EXPECT_FALSE(desk.next(200ms));
  EXPECT_TRUE(eventually([&] { return desk.stats().last_error.find("not in the allowlist") != std::string::npos; }));
  EXPECT_FALSE(desk.stats().connected);
  allow(line(desk_));
  expect_kept(desk, 3, 3);
}

TEST_F(Curve, AnAllowlistThatVanishesOrBreaksAllowsNobody) {
  allow(line(desk_));
  CaptureSender tracker(sender());
  for (const char* content : {"not a key", ""}) {
    if (*content)
      allow(content);
    else
      std::filesystem::remove(temp_.path() / "allowed");
    CaptureReceiver desk(receiver(tracker, desk_));
    ASSERT_TRUE(eventually([&] { return !desk.stats().last_error.empty(); }));
    EXPECT_FALSE(desk.stats().connected);
    EXPECT_THAT(tracker.stats().last_refusal, HasSubstr("allowed"));
  }
}

TEST_F(Curve, StartingWithABrokenSetupIsRefused) {
  allow("# fine\n" + line(desk_) + "short reconstructor x\n");
  expect_error<ConfigError>([&] { CaptureSender{sender()}; }, {"allowed", "line 3", "KEY role name"});
  allow(desk_.public_key + "\n");
  expect_error<ConfigError>([&] { CaptureSender{sender()}; }, {"line 1"});
  SenderOptions options = sender();
  options.allowlist.clear();
  expect_error<ConfigError>([&] { CaptureSender{options}; }, {"allowlist"});
  options.allowlist = temp_.path() / "none";
  expect_error<ConfigError>([&] { CaptureSender{options}; }, {"none", "no such file"});
  allow(line(desk_));
  const CaptureSender tracker(sender());
  ReceiverOptions no_server_key = receiver(tracker, desk_);
  no_server_key.server_public_key.clear();
  expect_error<ConfigError>([&] { CaptureReceiver{no_server_key}; }, {"public key"});
}

TEST(Keys, AreWrittenOnceReadableByTheirOwnerOnlyAndRead) {
  const TempFolder temp;
  const CurveKeys keys = generate_keys(temp.path() / "keys", "rig");
  const auto key_file = temp.path() / "keys/rig.key", pub_file = temp.path() / "keys/rig.pub";
  struct stat info {};
  ASSERT_EQ(::stat(key_file.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  const CurveKeys loaded = load_keys(key_file);
  EXPECT_EQ(loaded.public_key, keys.public_key);
  EXPECT_EQ(loaded.secret_key, keys.secret_key);
  EXPECT_EQ(load_public_key(pub_file), keys.public_key);
  expect_error([&] { generate_keys(temp.path() / "keys", "rig"); }, {"rig", "never overwritten"});
  EXPECT_EQ(load_keys(key_file).secret_key, keys.secret_key);
  EXPECT_NE(generate_keys(temp.path() / "keys", "other").secret_key, keys.secret_key);
  expect_error<ConfigError>([&] { generate_keys(temp.path(), "../up"); }, {"../up"});
}

TEST(Keys, FilesThatCannotBeTrustedAreRefused) {
  const TempFolder temp;
  const CurveKeys a = generate_keys(temp.path(), "a"), b = generate_keys(temp.path(), "b");
  ::chmod((temp.path() / "a.key").c_str(), 0644);
  expect_error([&] { load_keys(temp.path() / "a.key"); }, {"a.key", "chmod 600"});
  const auto mixed = temp.write("mixed.key", "public " + a.public_key + "\nsecret " + b.secret_key + "\n");
  ::chmod(mixed.c_str(), 0600);
  expect_error([&] { load_keys(mixed); }, {"mixed.key", "do not belong together"});
  const auto empty = temp.write("empty.key", "");
  ::chmod(empty.c_str(), 0600);
  expect_error([&] { load_keys(empty); }, {"empty.key", "not a key file"});
  expect_error([&] { load_keys(temp.path() / "none.key"); }, {"none.key"});
  expect_error([&] { load_public_key(temp.write("x.pub", "nonsense")); }, {"x.pub", "not a public key"});
}

}  // namespace
}  // namespace sheen
