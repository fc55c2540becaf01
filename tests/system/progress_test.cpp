// What `poretwin run` says of a run under way.
#include "cli/progress.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace poretwin::cli {
namespace {

using testing::HasSubstr;

TEST(Progress, TellsWhatIsLeftAndAfterCtrlCWhatItWaitsFor) {
  ProgressView view(true);
  EXPECT_THAT(view.text(), HasSubstr("starting, 0 s"));
  view.line(R"({"t": 0.0, "end": 2.0, "step": 0, "dt": 0.1, "waiting_for": ""})");
  view.line(R"({"t": 0.5, "end": 2.0, "step": 5, "dt": 0.1, "waiting_for": "solid"})");
  EXPECT_THAT(view.text(), HasSubstr("25 %  t = 0.5 of 2 s  step 5"));
  EXPECT_THAT(view.text(), HasSubstr(" left  waiting for solid"));
  view.stopping();
  EXPECT_EQ(view.text(), "stopping since 0 s at t = 0.5 s, step 5: waiting for solid");
  view.line(R"({"t": 0.6, "end": 2.0, "step": 6, "dt": 0.1, "waiting_for": ""})");
  EXPECT_EQ(view.text(), "stopping since 0 s at t = 0.6 s, step 6");
}

}  // namespace
}  // namespace poretwin::cli
