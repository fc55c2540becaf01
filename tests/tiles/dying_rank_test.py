"""When a rank dies, all ranks end at once, and the output says which it was.

dying_rank_test.py DYING_RANK MPIRUN [options ..]
"""

import os
import re
import signal
import subprocess
import sys
import time
import unittest

PROGRAM, *MPIRUN = sys.argv[1:]
# Within a second on a machine that is not busy otherwise; a hang is what is to be found out.
AT_ONCE = 10.0


class DyingRank(unittest.TestCase):
    def run_until_death(self, way):
        done = subprocess.run([*MPIRUN, "-n", "3", PROGRAM, way], capture_output=True, text=True, timeout=120)
        seconds = time.time() - float(re.search(r"dies at ([\d.]+)", done.stdout)[1])
        print(f"{way}: all ranks ended {seconds:.2f} s after rank 1 had begun to die", file=sys.stderr)
        self.assertLess(seconds, AT_ONCE)
        return done

    def test_a_killed_rank_is_named_by_mpirun(self):
        done = self.run_until_death("kill")
        self.assertNotEqual(done.returncode, 0)
        self.assertRegex(done.stderr, r"process rank 1 .*signal 9")

    def test_an_exception_ends_all_ranks_with_its_exit_code(self):
        done = self.run_until_death("throw")
        self.assertEqual(done.returncode, 4)
        self.assertIn("rank 1 of 3: error: particle 7 is at (nan, 0) m", done.stderr)

    def test_a_stopped_rank_is_named_by_the_next(self):
        done = self.run_until_death("stop")
        self.assertEqual(done.returncode, 3)
        self.assertRegex(done.stderr, r"rank 2 of 3: error: rank 1 \(tile 1\) on .* no sign of life for 2 s; .* step \d+:")

    def test_a_slow_rank_is_waited_for(self):
        done = self.run_until_death("slow")
        self.assertIn("rank 1 was waited for", done.stdout)
        self.assertEqual(done.returncode, 4)  # of the exception that ends the program

    def test_ranks_that_were_all_stopped_go_on(self):
        run = subprocess.Popen([*MPIRUN, "-n", "3", PROGRAM, "wait"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.assertEqual(run.stdout.readline(), "steps\n")
        ranks = subprocess.run(["pgrep", "-f", f"{PROGRAM} wait"], capture_output=True, text=True).stdout.split()
        ranks = [int(r) for r in ranks if int(r) != run.pid]
        self.assertEqual(len(ranks), 3)
        for signum, seconds in ((signal.SIGSTOP, 4.0), (signal.SIGCONT, 1.0)):
            for rank in ranks:
                os.kill(rank, signum)
            time.sleep(seconds)
        self.assertIsNone(run.poll(), "the run goes on")
        run.kill()
        run.communicate()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
