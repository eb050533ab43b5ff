// SPDX-License-Identifier: Apache-2.0
// The command line itself.

#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;

using CommandLine = GonioTest;

TEST_F(CommandLine, SaysItsVersionAndHelps) {
  EXPECT_THAT(Expect("--version").out, MatchesRegex("gonio [0-9]+\\.[0-9]+\\.[0-9]+\n"));
  const std::string help = Expect("--help").out;
  for (const char* command : {"run", "fit", "export", "compare", "simulate", "Exit codes"}) {
    EXPECT_THAT(help, HasSubstr(command));
  }
  EXPECT_THAT(Expect("run --help").out, HasSubstr("--max-poses"));
}

TEST_F(CommandLine, RefusesWhatMakesNoSense) {
  ExpectRefused(Gonio(""), 2, {"a command is needed"});
  ExpectRefused(Gonio("fly"), 2, {"fly"});
  ExpectRefused(Gonio("run"), 2, {"--out"});
  ExpectRefused(Gonio("run --out s --speed 3"), 2, {"--speed"});
  ExpectRefused(Gonio("run --out s --max-poses -1"), 2, {"--max-poses"});
  ExpectRefused(Gonio("run --out s --max-poses many"), 2, {"--max-poses"});
  ExpectRefused(Gonio("run --out s --seed x"), 2, {"--seed"});
  ExpectRefused(Gonio("fit a.csv --out f.yaml --lobes 9"), 2, {"--lobes"});
  ExpectRefused(Gonio("export s --to hologram f"), 2, {"--to"});
  ExpectRefused(Gonio("compare a.binary"), 2, {"other"});
  EXPECT_THAT(Files(), IsEmpty());
}

TEST_F(CommandLine, FailsWhenStandardOutputCannotBeWritten) {
  const Finished finished = Shell("\"$GONIO\" --help > /dev/full");
  ExpectRefused(finished, 1, {"standard output: cannot write"});
}

TEST_F(CommandLine, FindsItsConfigurationsElsewhereWhenTold) {
  ExpectRefused(Shell("GONIO_CONFIG_DIR=/nowhere \"$GONIO\" run --out s"), 2,
                {"GONIO_CONFIG_DIR", "/nowhere"});
  ExpectRefused(Shell("mkdir empty; GONIO_CONFIG_DIR=empty \"$GONIO\" run --out s"), 2,
                {"sim-rig.yaml: no such file, neither here nor in empty"});
}

}  // namespace
}  // namespace gonio
