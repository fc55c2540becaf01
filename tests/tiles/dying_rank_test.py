"""When a rank dies, all ranks end at once, and the output says which it was.

dying_rank_test.py DYING_RANK MPIRUN [options ..]
"""

import re
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


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
