// SPDX-License-Identifier: Apache-2.0
// Both daemons as processes, CURVE between them: what arrives over the network gives the model that the files give.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

TEST(SameModel, StreamedAsBuiltFromTheFiles) {
  const TempFolder temp;
  const BallDataset data{.folder = temp.path() / "data"};
  data.write();
  const auto built = temp.path() / "built", session = temp.path() / "session";
  expect_outcome(
      run_to_end(reconstructor({"build", data.folder, "--mesh", data.mesh(), "--out", built, "--loss", "0dB"})), 0, {});

  const SecureLink link(temp.path());
  Process desk(
      serve(data.mesh(), session, link.reconstructor_options() + Words{"--once", "--json", temp.path() / "desk.json"}));
  Process rig(patient_run({"--source", "dataset:" + data.folder.string(), "--json", temp.path() / "rig.json"}) +
              link.tracker_options());
  expect_outcome(wait_to_end(rig), 0, {"16 keyframes sent"});
  expect_outcome(wait_to_end(desk), 0, {"14 images added to the model", "2 held out"});

  expect_same_model(built, session / "model");
  const auto sent = nlohmann::json::parse(read_file(temp.path() / "rig.json"));
  EXPECT_EQ(sent["frames"]["sent"], 16);
  EXPECT_EQ(sent["link"]["acknowledged"], 16);
  EXPECT_EQ(sent["link"]["resent"], 0);
  const auto got = nlohmann::json::parse(read_file(temp.path() / "desk.json"));
  EXPECT_EQ(got["frames"]["received"], 16);
  EXPECT_EQ(got["frames"]["lost"], 0);
  EXPECT_EQ(got["frames"]["accepted"], 14);
  EXPECT_EQ(got["held_out"]["views"], 2);
  EXPECT_GT(got["bytes_per_patch"], 0);
  EXPECT_EQ(got["bytes_per_ring"], got["bytes_per_patch"]);
  for (const char* key : {"rank_histogram", "ingest_images_per_s", "ingest_ms", "latency_ms", "latency_to_model_ms",
                          "latency_to_picture_ms"})
    EXPECT_TRUE(got.contains(key)) << key << " is promised to scripts";
}

}  // namespace
}  // namespace sheen::testing
