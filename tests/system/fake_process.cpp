// Stands in for a process of a run. PORETWIN_FAKE_<process> sets its behaviour: "good" (default), "fail N", "crash",
// "follow" (fails with 3 after a moment, as a peer of a failed process does), "wait" (until SIGINT, then 130), "linger"
// (the same, a second later), "deaf" (ends only by SIGKILL), "lossy" (ends with 6 and warnings that put the result in
// doubt).
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <thread>

namespace {

volatile sig_atomic_t stopped = 0;

void stop(int) { stopped = 1; }

void sleep_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

void leave_results(const std::string& out, const std::string& name, const std::string& warnings) {
  std::ofstream(out + "/" + name + ".summary.json")
      << R"({"process": ")" << name
      << R"(", "exit": 0, "reason": "end", "wall_s": 0.1, "cpu_s": 0.05, "seconds": {"computing": 0.04},)"
      << R"( "steps": {"windows": 10}, "counters": {"particles": 7, "steps asleep": 3}, "warnings": [)" << warnings
      << R"(], "files": []})";
  if (name == "coupler") return;
  std::ofstream gauges(out + "/gauges." + name + ".csv");
  gauges << "time_s,gauge,value,unit\n";
  for (int i = 0; i <= 10; ++i) gauges << 0.1 * i << "," << name << "_ramp," << 2.0 * 0.1 * i << ",m\n";
}

}  // namespace

int main(int argc, char** argv) {
  const std::string name = PROCESS_NAME;
  std::map<std::string, std::string> options;
  for (int i = 1; i + 1 < argc; ++i)
    if (argv[i][0] == '-') options[argv[i]] = argv[i + 1];
  const char* given = std::getenv(("PORETWIN_FAKE_" + name).c_str());
  const std::string mood = given != nullptr ? given : "good";
  signal(SIGINT, stop);
  signal(SIGTERM, stop);
  if (options.count("--progress-fd") != 0) {
    const std::string line = "{\"t\": 0.5, \"end\": 1.0, \"step\": 5, \"dt\": 0.1, \"waiting_for\": \"solid\"}\n";
    if (write(std::atoi(options["--progress-fd"].c_str()), line.data(), line.size()) < 0) return 1;
  }
  if (mood.rfind("fail", 0) == 0) {
    std::fprintf(stderr, "[0] %s: starting\n[1] %s: error: pressure is not finite at particle 17\n", name.c_str(),
                 name.c_str());
    sleep_ms(100);
    return std::atoi(mood.c_str() + 5);
  }
  if (mood == "follow") {
    std::fprintf(stderr, "[1] %s: error: the other side gave up\n", name.c_str());
    return 3;
  }
  if (mood == "crash") std::abort();
  if (mood == "deaf") {
    signal(SIGINT, SIG_IGN);
    signal(SIGTERM, SIG_IGN);
    for (;;) sleep_ms(1000);
  }
  if (mood == "wait" || mood == "linger") {
    while (stopped == 0) sleep_ms(10);
    if (mood == "linger") sleep_ms(1000);
    return 130;
  }
  if (mood == "lossy") {
    std::fprintf(stderr, "[12:00:00] %s: warning: water particles lost (2 by t = 0.5 s): far outside\n", name.c_str());
    leave_results(options["--out"], name,
                  R"({"what": "water particles lost", "count": 3, "detail": "far outside", "result_in_doubt": true},)"
                  R"({"what": "cavitation", "count": 1, "detail": "", "result_in_doubt": false})");
    sleep_ms(600);
    return 6;
  }
  leave_results(options["--out"], name, "");
  return 0;
}
