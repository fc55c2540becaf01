#include "common/coupling/trace.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace poretwin::coupling {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(Trace, PartsBecomeOneFileAndALineCutShortIsLeftOut) {
  const fs::path out = fs::path(testing::TempDir()) / "trace";
  fs::remove_all(out);
  fs::create_directories(out);
  EXPECT_FALSE(join_traces(out));
  const Instant start{std::chrono::microseconds(5)};
  Trace(out, "solid").add("computing", start, start + std::chrono::nanoseconds(2500));
  Trace(out, "fluid").add("waiting", start, start);
  std::ofstream(trace_part(out, "fluid"), std::ios::app) << "{\"ph\":\"X\",\"na";
  EXPECT_TRUE(join_traces(out));
  const std::string text = text_of(out / "trace.json");
  EXPECT_NE(text.find(R"("name":"computing","pid":3)"), std::string::npos) << text;
  EXPECT_NE(text.find(R"("ts":5.000,"dur":2.500})"), std::string::npos) << text;
  EXPECT_NE(text.find(R"("name":"waiting","pid":2)"), std::string::npos) << text;
  EXPECT_EQ(text.find("\"na\n"), std::string::npos) << text;
  EXPECT_FALSE(fs::exists(trace_part(out, "fluid")));
  EXPECT_FALSE(fs::exists(trace_part(out, "solid")));
}

}  // namespace
}  // namespace poretwin::coupling
