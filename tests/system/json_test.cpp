// `--json`: valid JSON after success and failure, in a file and on stdout, where nothing else may be printed.
#include "tests/system/command.hpp"

#include <nlohmann/json.hpp>

namespace poretwin::testing_tools {
namespace {

using nlohmann::json;

class JsonOfCommands : public Command {
 protected:
  Outcome run(const std::string& to, const std::string& fluid_mood = "good") {
    return poretwin({"run", terzaghi().string(), "--out", out().string(), "--programs", PORETWIN_FAKES, "--no-pictures",
                     "--json", to},
                    {{"PORETWIN_FAKE_fluid", fluid_mood}});
  }
};

TEST_F(JsonOfCommands, ARunTellsHowItEnded) {
  const auto outcome = run("-");
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  const auto told = json::parse(outcome.out);
  EXPECT_EQ(told["command"], "run");
  EXPECT_EQ(told["exit"], 0);
  EXPECT_EQ(told["reason"], "end");
  EXPECT_EQ(told["out"], out().string());
  EXPECT_EQ(told["windows"], 10);
  EXPECT_EQ(told["processes"].size(), 3U);
  EXPECT_EQ(told["processes"][1]["process"], "fluid");
  EXPECT_EQ(told["processes"][1]["counters"]["steps asleep"], 3);
  EXPECT_GT(told["wall_s"], 0.0);
  for (const auto& file : told["files"]) EXPECT_TRUE(std::filesystem::exists(file.get<std::string>())) << file;
  EXPECT_THAT(outcome.err, testing::HasSubstr("where the time went")) << "the summary goes to stderr";
}

TEST_F(JsonOfCommands, ARunInDoubtTellsItsWarnings) {
  const auto file = (folder_ / "run.json").string();
  const auto outcome = run(file, "lossy");
  ASSERT_EQ(outcome.exit, 6);
  EXPECT_THAT(outcome.out, testing::HasSubstr("where the time went")) << "with a file, stdout is as ever";
  const auto told = json::parse(text_of(file));
  EXPECT_EQ(told["exit"], 6);
  EXPECT_EQ(told["warnings"][0]["process"], "fluid");
  EXPECT_EQ(told["warnings"][0]["what"], "water particles lost");
  EXPECT_EQ(told["warnings"][0]["count"], 3);
  EXPECT_EQ(told["warnings"][0]["result_in_doubt"], true);
}

TEST_F(JsonOfCommands, AFailedRunTellsItsReason) {
  const auto outcome = run("-", "fail 4");
  ASSERT_EQ(outcome.exit, 4);
  const auto told = json::parse(outcome.out);
  EXPECT_EQ(told["exit"], 4);
  EXPECT_THAT(told["reason"].get<std::string>(), testing::HasSubstr("pressure is not finite at particle 17"));
  EXPECT_FALSE(told.contains("error"));
}

TEST_F(JsonOfCommands, AFinishedRunTellsItsFiguresAgain) {
  ASSERT_EQ(run("-").exit, 0);
  const auto again = poretwin({"run", terzaghi().string(), "--out", out().string(), "--programs", PORETWIN_FAKES,
                               "--no-pictures", "--resume", "--json", "-"});
  ASSERT_EQ(again.exit, 0) << again.err;
  const auto told = json::parse(again.out);
  EXPECT_EQ(told["already_finished"], true);
  EXPECT_EQ(told["windows"], 10);
}

TEST_F(JsonOfCommands, CheckTellsWhatItPrints) {
  const auto outcome = poretwin({"check", terzaghi().string(), "--json", "-"});
  ASSERT_EQ(outcome.exit, 0);
  const auto told = json::parse(outcome.out);
  EXPECT_EQ(told["reason"], "sound");
  EXPECT_EQ(told["fluid"]["particles"], 400);
  EXPECT_EQ(told["solid"]["spacing_m"], 0.01);
  EXPECT_EQ(told["dimension"], 2);
  ASSERT_GE(told["intervals"].size(), 2U);
  EXPECT_LE(told["intervals"][0]["seconds"], told["intervals"][1]["seconds"]);
  EXPECT_GT(told["memory_bytes"], 1e6);
}

TEST_F(JsonOfCommands, AMistakeHasFileLineAndKey) {
  const auto wrong = changed_case("porosity", "porosty").string();
  for (const char* command : {"check", "run", "safety", "verify"}) {
    const auto plain = poretwin({command, wrong}), outcome = poretwin({command, wrong, "--json", "-"});
    EXPECT_EQ(outcome.exit, plain.exit) << command;
    const auto told = json::parse(outcome.out);
    EXPECT_EQ(told["command"], command);
    EXPECT_EQ(told["exit"], outcome.exit);
    EXPECT_EQ(told["reason"], told["error"]["message"]);
    if (std::string(command) == "verify") continue;  // it reports its missing verify.toml first
    EXPECT_EQ(outcome.exit, 2) << command;
    EXPECT_EQ(told["error"]["file"], wrong);
    EXPECT_EQ(told["error"]["line"], 13);
    EXPECT_EQ(told["error"]["key"], "soil[0].porosty");
    EXPECT_THAT(outcome.err, testing::HasSubstr("did you mean 'porosity'?"));
  }
}

TEST_F(JsonOfCommands, MissingFilesAndWrongCommandLinesAreTold) {
  const auto absent = poretwin({"check", (folder_ / "absent.toml").string(), "--json", "-"});
  EXPECT_EQ(absent.exit, 5);
  EXPECT_EQ(json::parse(absent.out)["error"]["file"], (folder_ / "absent.toml").string());
  EXPECT_EQ(json::parse(absent.out)["error"]["line"], nullptr);
  const auto unknown = poretwin({"run", terzaghi().string(), "--json=-", "--untill", "1"});
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_THAT(json::parse(unknown.out)["reason"].get<std::string>(), testing::HasSubstr("--untill"));
  const auto part = poretwin({"bench", "nothing", "--out", (folder_ / "bench").string(), "--json", "-"});
  EXPECT_EQ(part.exit, 2);
  EXPECT_EQ(json::parse(part.out)["exit"], 2);
}

TEST_F(JsonOfCommands, BenchTellsTheRowsOfItsParts) {
  const auto outcome = poretwin({"bench", "kernels", "--out", (folder_ / "bench").string(), "--json", "-"});
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  const auto told = json::parse(outcome.out);
  EXPECT_EQ(told["command"], "bench");
  EXPECT_TRUE(told["parts"]["kernels"].is_array());
}

// Triaxial compression from 10 kPa of soil with c = 0 and phi = 30 degrees: at failure three times the cell pressure.
TEST_F(JsonOfCommands, ElementTellsThePathOfASoil) {
  const std::vector<std::string> words{"element",    terzaghi().string(),
                                       "--set",      "solid.model=\"mohr_coulomb\"",
                                       "--test",     "triaxial",
                                       "--pressure", "10e3",
                                       "--out",      out().string(),
                                       "--json",     "-",
                                       "--steps",    "100"};
  auto by_strain = words, by_load = words, wrong = words;
  by_strain.insert(by_strain.end(), {"--strain", "0.05", "-0.05"});
  const auto outcome = poretwin(by_strain);
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  const auto told = json::parse(outcome.out);
  EXPECT_EQ(told["reason"], "end");
  EXPECT_EQ(told["columns"][4], "stress_yy_Pa");
  ASSERT_EQ(told["rows"].size(), 201U);
  EXPECT_NEAR(told["rows"][100][4].get<double>(), 30e3, 1.0);
  EXPECT_NEAR(told["rows"][200][4].get<double>(), 10e3 / 3.0, 1.0);
  EXPECT_THAT(text_of(out() / "element.csv"), testing::StartsWith("axial_strain,shear_strain,"));
  EXPECT_TRUE(std::filesystem::exists(out() / "element.png"));

  by_load.insert(by_load.end(), {"--stress", "40e3", "--no-pictures"});
  const auto too_much = poretwin(by_load);
  EXPECT_EQ(too_much.exit, 6);
  EXPECT_THAT(json::parse(too_much.out)["reason"].get<std::string>(), testing::HasSubstr("the soil bears no more"));
  EXPECT_EQ(poretwin(words).exit, 2) << "neither a strain nor a stress";
  wrong[5] = "triaxal";
  wrong.insert(wrong.end(), {"--strain", "0.05"});
  const auto unknown = poretwin(wrong);
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_THAT(unknown.err, testing::HasSubstr("test \"triaxal\": expected one of triaxial, triaxial_undrained"));
}

TEST_F(JsonOfCommands, ElementRefusesNumbersThatMeanNothing) {
  const auto tested = [&](std::vector<std::string> changes, const char* test = "triaxial") {
    std::vector<std::string> words{
        "element", terzaghi().string(), "--set",        "solid.model=\"mohr_coulomb\"", "--test", test,
        "--out",   out().string(),      "--no-pictures"};
    words.insert(words.end(), changes.begin(), changes.end());
    const auto outcome = poretwin(words);
    return std::to_string(outcome.exit) + " " + outcome.err;
  };
  using testing::HasSubstr;
  EXPECT_THAT(tested({"--pressure", "nan", "--strain", "0.05"}),
              HasSubstr("2 --pressure: expected a finite number >= 0, found nan"));
  EXPECT_THAT(tested({"--pressure", "-5", "--strain", "0.05"}), HasSubstr("expected a finite number >= 0, found -5"));
  EXPECT_THAT(tested({"--pressure", "1e4", "--strain", "inf"}), HasSubstr("2 --strain: expected a finite number"));
  EXPECT_THAT(tested({"--pressure", "1e4", "--stress", "nan"}), HasSubstr("2 --stress: expected a finite number"));
  // At 30 degrees and without cohesion a lateral stress of at least a third of the vertical one is needed.
  EXPECT_THAT(tested({"--pressure", "1e4", "--ratio", "0.32", "--strain", "0.01"}),
              HasSubstr("2 poretwin: --ratio 0.32: the soil cannot bear a lateral stress of 3200 Pa"));
  EXPECT_EQ(tested({"--pressure", "1e4", "--ratio", "0.34", "--strain", "0.01"})[0], '0');
  EXPECT_THAT(tested({"--pressure", "1e4", "--ratio", "0.5", "--strain", "0.01"}, "isotropic"),
              HasSubstr("all normal stresses are equal; expected 1"));
}

TEST_F(JsonOfCommands, TimesThatAreNoNumbersAreRefused) {
  const auto until = poretwin({"run", terzaghi().string(), "--out", out().string(), "--until", "nan"});
  EXPECT_EQ(until.exit, 2);
  EXPECT_THAT(until.err, testing::HasSubstr("--until: expected a finite number > 0, found nan"));
  const auto every = poretwin({"safety", out().string(), "--every", "nan"});
  EXPECT_EQ(every.exit, 2);
  EXPECT_THAT(every.err, testing::HasSubstr("--every: expected a finite number > 0, found nan"));
}

TEST_F(JsonOfCommands, AFileThatCannotBeWrittenIsNamed) {
  const auto outcome = poretwin({"check", terzaghi().string(), "--json", (folder_ / "absent" / "a.json").string()});
  EXPECT_EQ(outcome.exit, 5);
  EXPECT_THAT(outcome.err, testing::HasSubstr("absent/a.json: cannot be written"));
}

TEST_F(JsonOfCommands, VerifyTellsToStdoutToo) {
  const auto place = folder_ / "ramp";
  std::filesystem::create_directories(place);
  std::filesystem::copy_file(terzaghi(), place / "case.toml");
  std::ofstream(place / "verify.toml")
      << "[[metric]]\nname = \"ramp\"\nop = \"value\"\ngauge = \"fluid_ramp\"\nat = 0.5\nreference = 1.1\n"
         "tolerance = 0.2\nunit = \"m\"\n";
  const auto outcome = poretwin(
      {"verify", place.string(), "--out", (folder_ / "verify").string(), "--programs", PORETWIN_FAKES, "--json", "-"});
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["metrics"][0]["passed"], true);
}

}  // namespace
}  // namespace poretwin::testing_tools
