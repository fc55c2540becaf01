#include "cli/run_folder.hpp"

#include "common/case/document.hpp"
#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace poretwin::cli {
namespace fs = std::filesystem;
namespace {

constexpr std::array<const char*, 3> processes{"coupler", "fluid", "solid"};
constexpr int interrupted = static_cast<int>(ExitCode::interrupted);

fs::path lock_file(const fs::path& out) { return out / "run.lock"; }

bool is_lock(const fs::path& file) { return file.extension() == ".lock"; }

std::string subject(const fs::path& out) { return out.string() + ": another run writes into this folder"; }

/// Whether the folder contains no results: at most the files of a run that was refused or killed before it began.
bool holds_nothing(const fs::path& out) {
  return std::all_of(fs::directory_iterator(out), {}, [](const auto& entry) {
    return is_lock(entry.path()) || (entry.path().filename() == "log" && fs::is_empty(entry.path()));
  });
}

bool has_frames(const fs::path& out) {
  return fs::exists(out / "fluid.vtkhdf") || fs::exists(out / "solid.vtkhdf");
}

std::string text_of(const Node& table, const char* key) {
  const Node* found = table.find(key);
  return found != nullptr && found->kind == Node::Kind::text ? found->text : std::string();
}

/// Text such as "a run of terzaghi that finished at 2026-01-01T10:00:00Z".
std::string described(const RunRecord& record) {
  std::string text = fmt::format("a run of {}", record.case_name);
  if (!record.exit) return text + fmt::format(" that began at {} and never ended", record.started);
  if (*record.exit == 0) return text + fmt::format(" that finished at {}", record.ended);
  if (*record.exit == interrupted) return text + fmt::format(" that was interrupted at {}", record.ended);
  return text + fmt::format(" that failed at {} with exit code {}", record.ended, *record.exit);
}

RunRecord expect_record(const RunClaim& claim) {
  const auto record = fs::is_directory(claim.out) ? read_run_record(claim.out) : std::nullopt;
  if (!record)
    throw FileError(fmt::format("{}: nothing to resume: expected the folder of an earlier run, found no run.toml in it",
                                claim.out.string()));
  return *record;
}

/// Whether the run in the folder has already finished. Throws unless this run may resume it.
bool finished(const RunClaim& claim) {
  const RunRecord record = expect_record(claim);
  if (record.case_name != claim.case_name)
    throw CaseError(fmt::format("{}: holds {}: expected one of {}; nothing was touched", claim.out.string(),
                                described(record), claim.case_name));
  if (!record.identity.empty())
    expect_same((claim.out / "run.toml").string(), claim.identity, record.identity, claim.accept_changed_program);
  if (record.exit == 0) return true;
  if (!has_checkpoints(claim.out, claim.leader))
    throw FileError(
        fmt::format("{}: nothing to resume from: holds {} and left no checkpoint of the {}; begin anew without "
                    "--resume{}",
                    claim.out.string(), described(record), claim.leader,
                    has_frames(claim.out) ? ", with --overwrite" : ""));
  return false;
}

/// Describes the run that a new run replaces; empty: none. Throws unless a new run may use the folder.
std::string replaced_by(const RunClaim& claim) {
  const fs::path& out = claim.out;
  if (!fs::exists(out)) return {};
  if (!fs::is_directory(out))
    throw FileError(fmt::format("{}: expected a folder for the run, found a file", out.string()));
  if (holds_nothing(out)) return {};
  const auto record = read_run_record(out);
  if (!record)
    throw FileError(fmt::format(
        "{}: not empty and not the folder of an earlier run (no run.toml in it); choose another --out", out.string()));
  const std::string what = described(*record);
  if (claim.overwrite) return what;
  if (record->case_name != claim.case_name)
    throw FileError(fmt::format("{}: holds {}; replace it by one of {} with --overwrite, or choose another --out",
                                out.string(), what, claim.case_name));
  if (has_checkpoints(out, claim.leader))
    throw FileError(fmt::format("{}: holds {} and can go on from a checkpoint; go on with --resume, begin anew with "
                                "--overwrite, or choose another --out",
                                out.string(), what));
  if ((!record->exit || *record->exit == interrupted) && has_frames(out))
    throw FileError(fmt::format("{}: holds {} and left results, but no checkpoint; begin anew with --overwrite, or "
                                "choose another --out",
                                out.string(), what));
  return what;
}

}  // namespace

std::optional<RunRecord> read_run_record(const fs::path& out) {
  const fs::path file = out / "run.toml";
  if (!fs::exists(file)) return std::nullopt;
  const Node root = parse_document(read_text(file), file.string());
  RunRecord record{text_of(root, "case"),
                   text_of(root, "case_file"),
                   text_of(root, "started"),
                   text_of(root, "ended"),
                   text_of(root, "reason"),
                   std::nullopt,
                   {},
                   {}};
  if (const Node* exit = root.find("exit"); exit != nullptr && exit->kind == Node::Kind::integer)
    record.exit = static_cast<int>(exit->integer);
  if (const Node* identity = root.find("identity"); identity != nullptr)
    for (const auto& [name, value] : identity->entries) record.identity.emplace_back(name, value.text);
  if (const Node* overrides = root.find("overrides"); overrides != nullptr)
    for (const Node& assignment : overrides->items) record.overrides.push_back(assignment.text);
  return record;
}

RunFolder::RunFolder(const RunClaim& claim) : out_(claim.out) {
  const auto check = [&] {
    if (claim.resume)
      finished_ = finished(claim);
    else
      replaced_ = replaced_by(claim);
  };
  // A folder into which another run writes is refused first, whatever it contains. In a folder that belongs to no run
  // no lock file is made.
  if (fs::exists(lock_file(out_))) lock_ = FileLock(lock_file(out_), subject(out_), FileLock::Inherited::yes);
  check();
  if (finished_) return;
  std::error_code error;
  fs::create_directories(out_, error);
  if (error) throw FileError(fmt::format("{}: the folder cannot be made: {}", out_.string(), error.message()));
  if (!lock_) {
    lock_ = FileLock(lock_file(out_), subject(out_), FileLock::Inherited::yes);
    check();
  }
  // Processes that the user started directly have locks of their own.
  for (const char* name : processes)
    if (const auto file = out_ / fmt::format("{}.lock", name); fs::exists(file))
      FileLock(file, subject(out_), FileLock::Inherited::no);
  lock_.sign(fmt::format("poretwin run {}", claim.case_name));
  if (!claim.resume) clear();
}

void RunFolder::clear() const {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(out_)) {
    const std::string file = entry.path().filename().string(), ending = entry.path().extension().string();
    const bool ours = ending == ".vtkhdf" || ending == ".undo" || ending == ".xmf" || ending == ".h5" ||
                      file.ends_with(".summary.json") || (file.starts_with("gauges") && ending == ".csv") ||
                      (file.starts_with("trace") && ending == ".json") || file.starts_with("progress.json") ||
                      file == "log" || file == "pictures" || file == "checkpoints" || file == safety_folder;
    if (ours) fs::remove_all(entry.path(), error);
  }
  fs::create_directories(out_ / "log", error);
  if (error) throw FileError(fmt::format("{}: the folder cannot be made: {}", out_.string(), error.message()));
}

FileLock lock_ended_run(const fs::path& run, const std::string& what) {
  const std::string subject = run.string() + ": a run writes into this folder";
  FileLock lock(lock_file(run), subject, FileLock::Inherited::no);
  lock.sign(what);
  for (const char* name : processes)
    if (const auto file = run / fmt::format("{}.lock", name); fs::exists(file))
      FileLock(file, subject, FileLock::Inherited::no);
  return lock;
}

FileLock lock_folder(const fs::path& out, const std::string& what) {
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw FileError(fmt::format("{}: the folder cannot be made: {}", out.string(), error.message()));
  FileLock lock(lock_file(out), subject(out), FileLock::Inherited::yes);
  lock.sign(what);
  return lock;
}

}  // namespace poretwin::cli
