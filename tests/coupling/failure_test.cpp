// Every failure is reported with its cause to all processes, and the run ends in time.
#include "tests/coupling/coupled_run.hpp"
#include "tests/coupling/slow_line.hpp"

namespace poretwin::coupling {
namespace {

void expect_contains(const std::string& text, const std::vector<std::string>& parts) {
  for (const auto& part : parts)
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
}

class FailureOnEveryLine : public testing::TestWithParam<Line> {};
INSTANTIATE_TEST_SUITE_P(Lines, FailureOnEveryLine, testing::Values(Line::in_process, Line::ipc, Line::tcp),
                         [](const auto& line) { return line_name(line.param); });

TEST_P(FailureOnEveryLine, ADeathIsNamedToEverybodyAtOnce) {
  for (const Role role : {Role::fluid, Role::solid}) {
    MockKnobs knobs;
    knobs.die_at = 4;
    MockPhase fluid(Role::fluid, 2, still_square(Role::fluid), role == Role::fluid ? knobs : MockKnobs{});
    MockPhase solid(Role::solid, 2, still_square(Role::solid), role == Role::solid ? knobs : MockKnobs{});
    CoupledRun run;
    run.line = GetParam();
    run.run(&fluid, &solid);
    const std::string name(to_string(role));
    expect_contains(run.coupler.error, {name + " died", "step 4", "last message PUBLICATION step 3"});
    EXPECT_EQ(run.coupler.code, ExitCode::peer);
    const Fate& survivor = role == Role::fluid ? run.solid : run.fluid;
    expect_contains(survivor.error, {"aborted by " + name, "died", "step 4"});
    EXPECT_EQ(survivor.code, ExitCode::peer);
    EXPECT_LT(run.wall, 3.0);
  }
}

/// A hub in which the first participant that says goodbye is out of reach before the coupler has read it.
class GoneAtGoodbye final : public Hub {
 public:
  /// missed: set to true when a message could not be delivered.
  GoneAtGoodbye(std::unique_ptr<Hub> hub, bool& missed) : hub_(std::move(hub)), missed_(missed) {}
  bool send(const std::string& line, Frames frames) override {
    const bool sent = (!goodbye_ || goodbye_->line != line) && hub_->send(line, std::move(frames));
    missed_ = missed_ || !sent;
    return sent;
  }
  std::optional<Event> receive(Milliseconds timeout) override {
    if (missed_ && goodbye_) return std::exchange(goodbye_, std::nullopt);
    if (goodbye_) {  // nothing else arrives before it
      std::this_thread::sleep_for(timeout);
      return std::nullopt;
    }
    auto event = hub_->receive(timeout);
    if (missed_ || !event || event->frames.empty() || !std::holds_alternative<Bye>(decode(event->frames).body))
      return event;
    goodbye_ = std::move(event);
    return std::nullopt;
  }
  [[nodiscard]] std::string address() const override { return hub_->address(); }

 private:
  std::unique_ptr<Hub> hub_;
  bool& missed_;
  std::optional<Event> goodbye_;
};

TEST(Failure, AHeartbeatThatMeetsAGoodbyeIsNone) {
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid)), solid(Role::solid, 2, still_square(Role::solid));
  CoupledRun run;
  bool missed = false;
  run.wrap = [&](std::unique_ptr<Hub> hub) { return std::make_unique<GoneAtGoodbye>(std::move(hub), missed); };
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_TRUE(missed);
}

TEST_P(FailureOnEveryLine, AFrozenPeerIsToldFromASlowOne) {
  MockKnobs knobs;
  CoupledRun run;
  run.line = GetParam();
  run.broker.frozen_deadline = Milliseconds(400);
  knobs.freeze_at = 2;
  knobs.freeze_for = Milliseconds(1500);
  knobs.on_freeze = [&] { run.silence(Role::solid); };
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid)), solid(Role::solid, 2, still_square(Role::solid), knobs);
  run.run(&fluid, &solid);
  expect_contains(run.coupler.error, {"solid is frozen", "step 2", "last message"});
  expect_contains(run.fluid.error, {"aborted by solid", "frozen"});
  EXPECT_EQ(run.fluid.code, ExitCode::peer);
}

TEST_P(FailureOnEveryLine, AFrozenPeerIsNamedAtOnceAndMayComeBack) {
  MockKnobs knobs;
  CoupledRun run;
  run.line = GetParam();
  run.settings.end = 0.3;
  run.broker.frozen_notice = Milliseconds(700);  // a busy machine may delay the coupler by a third of it
  knobs.freeze_at = 2;
  knobs.freeze_for = Milliseconds(1500);
  knobs.on_freeze = [&] { run.silence(Role::solid); };
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid)), solid(Role::solid, 2, still_square(Role::solid), knobs);
  run.run(&fluid, &solid);
  run.expect_success();
  std::string log;
  for (const auto& line : run.log) log += line + "\n";
  expect_contains(log, {"solid is frozen", "step 2", "last message PUBLICATION step 1", "solid is back after 1."});
}

TEST_P(FailureOnEveryLine, ASlowPeerIsNeverEvicted) {
  MockKnobs knobs;
  knobs.per_step = Milliseconds(700);
  CoupledRun run;
  run.line = GetParam();
  run.settings.end = 0.2;
  run.broker.frozen_deadline = Milliseconds(300);
  run.broker.say_every = Milliseconds(200);
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid)), solid(Role::solid, 2, still_square(Role::solid), knobs);
  run.run(&fluid, &solid);
  run.expect_success();
  bool said = false;
  for (const auto& line : run.log)
    said = said || line.find("waiting for solid (0 s): computing step") != std::string::npos;
  EXPECT_TRUE(said) << testing::PrintToString(run.log);
}

TEST(Failure, NanNamesFieldPointValueSenderAndStep) {
  MockKnobs knobs;
  knobs.nan_at = 3;
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid), knobs), solid(Role::solid, 2, still_square(Role::solid));
  CoupledRun run;
  run.run(&fluid, &solid);
  for (const Fate* fate : {&run.coupler, &run.fluid, &run.solid}) {
    expect_contains(fate->error, {"'fluid'", "step 3", "'pore_pressure'", "point 99", "(0.95, 0.95)", "nan"});
    EXPECT_EQ(fate->code, ExitCode::peer);
  }
}

TEST(Failure, TheFirstBadValueIsFoundWhereverItStands) {
  for (const double bad : {std::nan(""), 1.0 + 1e-15, -1e-300, std::log(0.0), -std::log(0.0)})
    for (const std::size_t n : {1u, 63u, 64u, 65u, 200u}) {
      std::vector<double> values(n, 1.0);
      values[0] = 0.0;
      ASSERT_EQ(first_outside(values, 0.0, 1.0), n);
      for (std::size_t k = n; k-- > 0;) {  // the points after it are wrong already
        values[k] = bad;
        ASSERT_EQ(first_outside(values, 0.0, 1.0), k) << bad << " among " << n;
      }
    }
  EXPECT_EQ(first_outside({}, 0.0, 1.0), 0u);
}

TEST(Failure, FractionsAndLengthsAreBounded) {
  auto bad_fraction = [](double t) {
    return formula_publication(Role::solid, t, lattice_points(2, {0.0, 0.0}, {1.0, 1.0}, 0.25),
                               [](const std::string& name, int, const double*, double now) {
                                 return name == field::solid_volume_fraction && now > 0.15 ? 1.25 : 0.5;
                               });
  };
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid, 0.25)), solid(Role::solid, 2, bad_fraction);
  CoupledRun run;
  run.run(&fluid, &solid);
  expect_contains(run.coupler.error, {"'solid'", "solid_volume_fraction", "[0, 1)", "1.25", "step 2"});

  auto bad_length = [](double t) {
    auto out = formula_publication(Role::fluid, t, lattice_points(2, {0.0, 0.0}, {1.0, 1.0}, 0.25));
    out.points.smoothing_length[3] = 0.0;
    return out;
  };
  MockPhase other_fluid(Role::fluid, 2, bad_length), other_solid(Role::solid, 2, still_square(Role::solid, 0.25));
  CoupledRun other;
  other.run(&other_fluid, &other_solid);
  expect_contains(other.coupler.error, {"'fluid'", "@smoothing_length", "point 3", "positive", "got 0"});
}

/// Values that no soil and no water can have, from the second window on, are refused before the other side uses them.
TEST(Failure, NonsenseIsNamedByFieldPointValueSenderAndStep) {
  using Spoil = std::function<void(Publication&)>;
  const auto at = [](Publication& p, std::string_view name, double value) {
    for (auto& field : p.fields)
      if (field.name == name) field.values[static_cast<std::size_t>(3 * field.components)] = value;
  };
  const auto value = [&](std::string_view name, double bad) {
    return Spoil([=](Publication& p) { at(p, name, bad); });
  };
  struct Nonsense {
    Role sender;
    Spoil spoil;
    std::vector<std::string> words;
  };
  const std::string place = "point 3 at (0.35, 0.05)";
  const std::vector<Nonsense> all{
      {Role::solid, value(field::hydraulic_conductivity, 0.0), {"'hydraulic_conductivity', " + place, "(0,", "got 0"}},
      {Role::solid, value(field::hydraulic_conductivity, -1e-3), {"'hydraulic_conductivity'", "got -0.001"}},
      {Role::solid, value(field::solid_volume_fraction, 1.0), {"'solid_volume_fraction', " + place, "[0, 1)", "got 1"}},
      {Role::solid, value(field::grain_density, 0.0), {"'grain_density', " + place, "kg/m3", "got 0"}},
      {Role::solid, value(field::grain_density, -2600.0), {"'grain_density'", "got -2600"}},
      {Role::solid, value(field::constrained_modulus, -1e6), {"'constrained_modulus'", "got -1000000"}},
      {Role::solid, value(field::forchheimer_coefficient, -1.0), {"'forchheimer_coefficient'", "got -1"}},
      {Role::solid, value(field::yielding, 50.0), {"'yielding'", "[0, 1]", "got 50"}},
      {Role::solid, value(field::solid_velocity, 1e200), {"'solid_velocity', " + place, "m/s", "got 1e+200"}},
      {Role::solid, value(field::returned_impulse, 1e300), {"'returned_impulse', " + place, "N s", "got 1e+300"}},
      {Role::fluid, value(field::drag_impulse, -1e18), {"'drag_impulse', " + place, "N s", "got -1e+18"}},
      {Role::fluid, value(field::pore_pressure, 1e30), {"'pore_pressure'", "Pa", "got 1e+30"}},
      {Role::solid, [](Publication& p) { p.points.position[6] = 1e300; }, {"'@position', point 3", "got 1e+300"}},
      {Role::solid, [](Publication& p) { p.points.smoothing_length[3] = 1e6; }, {"'@smoothing_length', " + place}},
      {Role::solid, [](Publication& p) { p.points.smoothing_length[3] = 1e-9; }, {"'@smoothing_length', " + place}},
      {Role::solid,
       [](Publication& p) {
         for (std::size_t k = 0; k < p.points.position.size(); ++k) p.points.position[k] = 0.5;
       },
       {"'@position', point 0 at (0.5, 0.5)", "100 points", "side by side", "within 0 m"}},
      {Role::solid,
       [](Publication& p) {
         for (auto& v : p.points.volume) v *= 1000.0;
         for (auto& h : p.points.smoothing_length) h *= 10.0;
       },
       {"'@position'", "side by side"}},
  };
  for (const auto& one : all) {
    std::uint64_t revision = 0;
    const auto formula = [&](double t) {
      auto out = still_square(one.sender)(t);
      if (t < 0.15) return out;
      one.spoil(out);
      out.points.revision = ++revision;
      return out;
    };
    const auto of = [&](Role role) { return role == one.sender ? MockPhase::Formula(formula) : still_square(role); };
    MockPhase fluid(Role::fluid, 2, of(Role::fluid)), solid(Role::solid, 2, of(Role::solid));
    CoupledRun run;
    run.run(&fluid, &solid);
    for (const Fate* fate : {&run.coupler, &run.fluid, &run.solid}) EXPECT_EQ(fate->code, ExitCode::peer);
    expect_contains(run.coupler.error, one.words);
    expect_contains(run.coupler.error, {"'" + std::string(to_string(one.sender)) + "'", "step 2", "expected"});
  }
}

TEST(Failure, DivergenceKeepsItsExitCodeEverywhere) {
  MockKnobs knobs;
  knobs.diverge_at = 2;
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid), knobs), solid(Role::solid, 2, still_square(Role::solid));
  CoupledRun run;
  run.run(&fluid, &solid);
  for (const Fate* fate : {&run.coupler, &run.fluid, &run.solid}) {
    expect_contains(fate->error, {"diverged on purpose in step 2"});
    EXPECT_EQ(fate->code, ExitCode::diverged);
  }
}

TEST(Failure, AMissingPeerIsNamedAndTheOtherToldWhy) {
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid));
  CoupledRun run;
  run.broker.wait_deadline = Milliseconds(500);
  run.broker.say_every = Milliseconds(100);
  run.run(&fluid, nullptr);
  expect_contains(run.coupler.error, {"solid did not come within 0.5 s"});
  expect_contains(run.fluid.error, {"aborted by solid", "did not come"});
  ASSERT_GE(run.log.size(), 2u);
  expect_contains(run.log[run.log.size() - 1], {"waiting for solid"});
}

TEST(Failure, WhoWaitsForTheCouplerSaysSo) {
  std::vector<std::string> said;
  ParticipantOptions options;
  options.welcome_deadline = Milliseconds(700);
  options.say_every = Milliseconds(100);
  options.say = [&](const std::string& line) { said.push_back(line); };
  const std::string address = "ipc:///tmp/poretwin-nobody-" + std::to_string(getpid());
  Participant participant(connect_socket(address), Role::solid, MockPhase(Role::solid, 2, {}).contract(), options);
  EXPECT_THROW(participant.join(), PeerError);
  ASSERT_GE(said.size(), 3u);
  EXPECT_NE(said.front().find("solid: waiting for the coupler at " + address), std::string::npos) << said.front();
  // The same while it requests the case.
  said.clear();
  const auto line = connect_socket(address);
  EXPECT_THROW(request_case(*line, Role::solid, options), PeerError);
  EXPECT_GE(said.size(), 3u);
}

TEST(Failure, NobodyAnswers) {
  ParticipantOptions options;
  options.welcome_deadline = Milliseconds(300);
  for (const char* address : {"ipc:///tmp/poretwin-nobody", "tcp://127.0.0.1:9"}) {
    MockPhase fluid(Role::fluid, 2, still_square(Role::fluid));
    Participant participant(connect_socket(address), Role::fluid, fluid.contract(), options);
    try {
      participant.join();
      FAIL() << "joined nobody";
    } catch (const PeerError& error) {
      expect_contains(error.what(), {"no coupler answered", address, "0.3 s"});
    }
  }
}

/// Runs a correct solid with a fluid whose contract `spoil` changes; the coupler must refuse the fluid and name
/// `parts`.
void expect_refused(const std::function<void(Contract&)>& spoil, const std::vector<std::string>& parts) {
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid)), solid(Role::solid, 2, still_square(Role::solid));
  Contract contract = fluid.contract();
  spoil(contract);
  fluid.set_contract(contract);
  CoupledRun run;
  run.broker.wait_deadline = Milliseconds(300);
  run.run(&fluid, &solid);
  const bool fluid_refused = run.fluid.error.find("refused by the coupler") != std::string::npos;
  const Fate& refused = fluid_refused ? run.fluid : run.solid;
  expect_contains(refused.error, parts);
  EXPECT_EQ(refused.code, ExitCode::peer);
  expect_contains(run.coupler.error, {"did not come", "refused meanwhile"});
  expect_contains(run.coupler.error, parts);
}

TEST(Handshake, RefusesNamingWhatDiffers) {
  expect_refused([](Contract& c) { c.dimension = 3; }, {"dimension: expected 2, got 3"});
  expect_refused([](Contract& c) { c.case_digest = "other"; }, {"case_digest: expected mock, got other"});
  expect_refused([](Contract& c) { c.gives[0].unit = "kPa"; }, {"pore_pressure", "Pa", "kPa"});
  expect_refused([](Contract& c) { c.takes[0].components = 1; }, {"solid_velocity", "2 components", "1 components"});
  expect_refused([](Contract& c) { c.gives.erase(c.gives.begin()); },
                 {"pore_pressure", "a giver of this field", "none"});
}

TEST(Handshake, RefusesASecondOfOneRole) {
  InProcess in_process;
  auto hub = in_process.hub();
  BrokerOptions options;
  options.case_digest = "mock";
  options.wait_deadline = Milliseconds(500);
  std::string first, second;
  auto join = [&](std::string& error) {
    MockPhase fluid(Role::fluid, 2, still_square(Role::fluid));
    try {
      ParticipantOptions short_wait;
      short_wait.welcome_deadline = Milliseconds(2000);
      Participant participant(in_process.line(), Role::fluid, fluid.contract(), short_wait);
      participant.join();
      static_cast<void>(participant.receive());
    } catch (const Error& caught) {
      error = caught.what();
    }
  };
  std::thread a([&] { join(first); }), b([&] { join(second); });
  Broker broker(*hub, options);
  Schedule schedule(broker, make_mapping(2), {1.0, {}, 0.0, 0.0});
  EXPECT_THROW(schedule.run(), PeerError);
  a.join();
  b.join();
  expect_contains(first + second, {"role: expected solid, got a second fluid", "aborted by solid"});
}

/// Sends one raw message to a broker and returns the answer.
Message answer_to(Message message) {
  InProcess in_process;
  auto hub = in_process.hub();
  BrokerOptions options;
  options.wait_deadline = Milliseconds(300);
  auto line = in_process.line();
  line->send(encode(std::move(message)));
  Broker broker(*hub, options);
  EXPECT_THROW(broker.gather(), PeerError);
  const auto frames = line->receive(Milliseconds(100));
  EXPECT_TRUE(frames);
  return frames ? decode(*frames) : Message{};
}

TEST(Handshake, RefusesAnotherProtocolAndUnknownRoles) {
  Message future = message_of(Hello{"fluid", {}, "", 0, ""});
  future.major = 2;
  future.minor = 7;
  const auto refused = std::get<Reject>(answer_to(future).body);
  EXPECT_EQ(refused.code, RejectCode::protocol);
  EXPECT_EQ(refused.expected, "1.x");
  EXPECT_EQ(refused.got, "2.7");

  const auto gas = std::get<Reject>(answer_to(message_of(Hello{"gas", {}, "", 0, ""})).body);
  EXPECT_EQ(gas.code, RejectCode::role);
  EXPECT_EQ(gas.got, "'gas'");
}

TEST(Wire, FrameSizesAreCheckedBeforeUse) {
  Message message = message_of(PublicationBody{}, 3);
  message.sender = "fluid";
  message.arrays.push_back({"pore_pressure", "Pa", 2, {1.0, 2.0, 3.0, 4.0}});
  const Frames good = encode(message);
  EXPECT_EQ(decode(good).arrays[0].take(), message.arrays[0].values);
  auto refused = [](const Frames& frames) {
    try {
      decode(frames);
    } catch (const PeerError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  Frames bad = good;
  bad[1].size -= 8;
  expect_contains(refused(bad), {"pore_pressure", "'fluid'", "step 3", "2 points", "24 bytes"});
  bad[1].size = 3;
  expect_contains(refused(bad), {"3 bytes"});
  bad.pop_back();
  expect_contains(refused(bad), {"announces 1 arrays, 0 frames"});
  expect_contains(refused({}), {"not a poretwin header"});
  expect_contains(refused({Frame::of(std::string("\xff\xff\xff\xff nonsense"))}), {"not a poretwin header"});
}

TEST(Wire, OnlyLoopbackWithoutTheFlag) {
  EXPECT_THROW(bind_socket("tcp://*:45671"), Error);
  EXPECT_THROW(bind_socket("tcp://0.0.0.0:45671"), Error);
  EXPECT_THROW(bind_socket("nonsense"), Error);
  EXPECT_NE(bind_socket("tcp://0.0.0.0:*", true)->address().find("tcp://"), std::string::npos);
}

TEST(Latency, ASlowLineIsAWorkingLine) {
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid)), solid(Role::solid, 2, still_square(Role::solid));
  std::optional<testing_tools::SlowLine> line;
  CoupledRun run;
  run.line = Line::tcp;
  run.route = [&](const std::string& address) { return line.emplace(address, Milliseconds(20)).address(); };
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(run.report.windows, 10u);
  EXPECT_GT(run.wall, 0.8);  // ten windows of four messages, one after the other: they did pass through the slow line
  for (const auto& text : run.log) EXPECT_EQ(text.find("frozen"), std::string::npos) << text;
}

}  // namespace
}  // namespace poretwin::coupling
