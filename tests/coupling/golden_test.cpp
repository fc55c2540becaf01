// One message of every kind is compared with bytes kept in golden/, so that the protocol does not change by accident.
// After an intended change: raise the version, run with PORETWIN_WRITE_GOLDEN=1, and check the difference.
#include "common/coupling/message.hpp"
#include "common/coupling/standard_contract.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace poretwin::coupling {
namespace {

namespace fs = std::filesystem;

const fs::path folder = fs::path(PORETWIN_SOURCE_DIR) / "tests" / "coupling" / "golden";

Message filled(Body body) {
  Message m;
  m.minor = 1;
  m.session = "0123456789abcdef";
  m.sender = "solid";
  m.sequence = 300;
  m.step = 7;
  m.iteration = 2;
  m.time = 0.25;
  m.interval = 0.125;
  m.body = std::move(body);
  return m;
}

std::vector<Message> one_of_each() {
  std::vector<Message> all;
  Hello hello;
  hello.role = "fluid";
  hello.contract = {3,
                    "00ff00ff00ff00ff",
                    {{"pore_pressure", "Pa", 1, Mapping::consistent, ""},
                     {"predicted_solid_velocity", "m/s", 3, Mapping::consistent, "soil_fraction"}},
                    {{"returned_impulse", "N s", 3, Mapping::conservative, ""}},
                    "a = 1\n"};
  hello.software = "golden 1";
  hello.process = 4711;
  hello.host = "here";
  all.push_back(filled(hello));
  all.push_back(filled(Welcome{0.5, 30.0}));
  all.push_back(filled(Reject{RejectCode::field, "pore_pressure", "unit Pa", "unit kPa", 0.0, "why"}));
  auto publication = filled(PublicationBody{0.75, "viscosity"});
  publication.points = {2, 5, 3, 2, true};
  publication.arrays = {{std::string(position_array), "m", 2, {0.0, 1.0, -2.0, 3.5, 1e-300, 1e300}},
                        {std::string(volume_array), "m^2", 1, {0.5, 0.25, 0.125}},
                        {std::string(smoothing_length_array), "m", 1, {1.0, 1.0, 1.0}},
                        {std::string(owner_array), "1", 1, {0.0, 1.0, -1.0}},
                        {"pore_pressure", "Pa", 1, {1000.0, -0.0, 3.141592653589793}}};
  all.push_back(publication);
  auto initialise = filled(Initialise{true, false});
  initialise.points = {2, 5, 0, 0, false};
  initialise.arrays = {{std::string(coverage_array), "1", 1, {}}, {"solid_velocity", "m/s", 2, {}}};
  all.push_back(initialise);
  all.push_back(filled(Advance{false, true}));
  all.push_back(filled(Restore{"too long"}));
  all.push_back(filled(Finish{"end", true, true}));
  all.push_back(filled(Bye{"end"}));
  all.push_back(filled(Abort{"fluid", "diverged", ExitCode::diverged}));
  all.push_back(filled(Heartbeat{"computing", "solid", 1.5, true}));
  all.push_back(filled(CaseRequest{"solid"}));
  all.push_back(filled(CaseFile{"[case]\n", {"case.end_time=1"}, "00ff00ff00ff00ff", 2}));
  all.push_back(filled(CheckpointOrder{"8f3a-7", {"8f3a-5", "8f3a-3"}}));
  all.push_back(filled(CheckpointWritten{"8f3a-7"}));
  all.push_back(filled(Resume{"8f3a-7"}));
  return all;
}

std::string hex(const Frame& frame) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string out;
  for (std::size_t k = 0; k < frame.size; ++k) {
    const auto byte = static_cast<unsigned char>(frame.data[k]);
    out += digits[byte >> 4];
    out += digits[byte & 15];
  }
  return out + "\n";
}

std::string hex(const Frames& frames) {
  std::string out;
  for (const auto& frame : frames) out += hex(frame);
  return out;
}

Frames from_hex(const std::string& text) {
  Frames frames;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::string bytes;
    for (std::size_t k = 0; k + 1 < line.size(); k += 2)
      bytes += static_cast<char>(std::stoi(line.substr(k, 2), nullptr, 16));
    frames.push_back(Frame::of(std::move(bytes)));
  }
  return frames;
}

TEST(Golden, EveryKindOfMessageKeepsItsBytes) {
  const auto all = one_of_each();
  ASSERT_EQ(all.size(), std::variant_size_v<Body>);
  for (const auto& message : all) {
    const auto file = folder / (std::string(name_of(message.body)) + ".hex");
    const std::string now = hex(encode(message));
    if (std::getenv("PORETWIN_WRITE_GOLDEN") != nullptr) std::ofstream(file) << now;
    std::stringstream then;
    then << std::ifstream(file).rdbuf();
    EXPECT_EQ(now, then.str()) << file;
    // A message that was read is written again with the same bytes.
    EXPECT_EQ(hex(encode(decode(from_hex(then.str())))), then.str()) << file;
  }
}

/// Fields added later are transmitted, too; an old HELLO, kept above, reads as one that keeps no checkpoints.
TEST(Golden, HelloSaysWhatItCanResumeFrom) {
  auto message = one_of_each().front();
  EXPECT_FALSE(std::get<Hello>(decode(encode(message)).body).keeps_checkpoints);
  auto& hello = std::get<Hello>(message.body);
  hello.keeps_checkpoints = true;
  hello.checkpoints = {"8f3a-7", "8f3a-5"};
  const auto back = std::get<Hello>(decode(encode(message)).body);
  EXPECT_TRUE(back.keeps_checkpoints);
  EXPECT_EQ(back.checkpoints, hello.checkpoints);
}

/// Announced sizes are compared with the received ones before they are used.
TEST(Golden, LiesAboutSizesAreFound) {
  const auto all = one_of_each();
  const auto good = encode(all[3]);
  auto missing = good;
  missing.pop_back();
  EXPECT_THROW(decode(missing), PeerError);
  auto extra = good;
  extra.push_back(Frame::of(std::string(8, 'x')));
  EXPECT_THROW(decode(extra), PeerError);
  for (const std::size_t size : {0u, 8u, 23u, 25u, 32u}) {
    auto wrong = good;
    wrong[2] = Frame::of(std::string(size, '\0'));
    EXPECT_THROW(decode(wrong), PeerError) << size;
  }
  EXPECT_THROW(decode({}), PeerError);
  EXPECT_THROW(decode({Frame::of(std::string("hello there"))}), PeerError);
}

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(StandardContract, StandsInTheProtocolsPageAndInThePythonClient) {
  const fs::path root = PORETWIN_SOURCE_DIR;
  EXPECT_NE(text_of(root / "docs" / "protocol.md").find(describe_contract()), std::string::npos)
      << "write its tables anew with: poretwin exchange-fields";
  EXPECT_EQ(text_of(root / "clients" / "python" / "poretwin" / "contract.py"), python_contract())
      << "write it anew with: poretwin exchange-fields --python > clients/python/poretwin/contract.py";
}

TEST(StandardContract, WhatStandInsGiveIsLetIn) {
  for (const auto& f : standard_contract()) {
    EXPECT_GE(f.at_rest, f.bounds.low) << f.name;
    EXPECT_LE(f.at_rest, f.bounds.high) << f.name;
    if (!f.mask.empty()) {
      ASSERT_NE(standard_field(f.mask), nullptr) << f.name;
      EXPECT_EQ(standard_field(f.mask)->giver, f.giver) << f.name;
    }
  }
}

}  // namespace
}  // namespace poretwin::coupling
