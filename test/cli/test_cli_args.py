"""Commands and options: what is not understood is named, with the nearest word that would be."""
from cli import check, done, expect, run

check("no_command_is_named", [], status=2,
      err="lithe: a command is missing: run, check, mesh, convert, study, verify or info; 'lithe --help' says more\n")
check("unknown_command_gets_the_nearest", ["rum", "a.yaml"], status=2,
      err="lithe: unknown command 'rum'; did you mean 'run'?\n")
check("unknown_option_gets_the_nearest", ["run", "a.yaml", "--theads", "2"], status=2,
      err="lithe: unknown option '--theads' for run; did you mean '--threads'?\n")
check("option_of_another_command_is_refused", ["info", "--set", "a=b"], status=2,
      err="lithe: unknown option '--set' for info; did you mean '--help'?\n")
check("missing_scene_is_named", ["run"], status=2,
      err="lithe: run: a scene file is missing\nusage: lithe run SCENE [-o DIR] [options]\n"
      "       lithe run --resume DIR [options]\n")
check("second_scene_is_refused", ["check", "a.yaml", "b.yaml"], status=2,
      err="lithe: check: one word too many: 'b.yaml'\nusage: lithe check SCENE [options]\n")
check("convert_needs_a_deck", ["convert"], status=2,
      err="lithe: convert: a deck file is missing\nusage: lithe convert DECK.inp SCENE.yaml [--step N]\n")
check("convert_needs_a_scene", ["convert", "a.inp"], status=2,
      err="lithe: convert: a scene file is missing\nusage: lithe convert DECK.inp SCENE.yaml [--step N]\n")
check("steps_count_from_one", ["convert", "a.inp", "a.yaml", "--step", "0"], status=2,
      err="lithe: --step: expected a number from 1 to 1000000, got '0'\n")
check("missing_value_is_named", ["run", "a.yaml", "-o"], status=2,
      err="lithe: option '-o' needs a value: --out PATH\n")
check("value_of_a_flag_is_refused", ["run", "a.yaml", "--json=yes"], status=2,
      err="lithe: option '--json' takes no value, got 'yes'\n")
check("threads_must_be_a_number", ["run", "a.yaml", "--threads", "two"], status=2,
      err="lithe: --threads: expected a number from 1 to 4096, got 'two'\n")
check("set_needs_an_equals_sign", ["run", "a.yaml", "--set", "bodies"], status=2,
      err="lithe: --set: expected KEY=VALUE, as in bodies.0.method.degree=2, got 'bodies'\n")
check("version_goes_to_standard_output", ["--version"], out="lithe 0.1.0\n")
check("help_of_a_command", ["check", "--help"], out="""usage: lithe check SCENE [options]

check a scene and say what a run would need

Options:
  --set KEY=VALUE        override a value: --set bodies.0.method.degree=2
  --threads N            threads to use (all cores if not given)
  --json                 print the result as JSON on standard output
  -q, --quiet            print nothing but errors
  -h, --help             print this help
  --version              print the version
""")
got = run("--help")
expect("help_names_every_command", got.returncode == 0 and
       all("\n  %s " % c in got.stdout for c in ("run", "check", "mesh", "convert", "study", "info")), got.stdout)
got = run("info")
expect("info_tells_version_engines_and_licence", got.returncode == 0 and got.stderr == "" and
       got.stdout.startswith("lithe       0.1.0\n") and "\nengines     cholesky, pcg, multigrid\n" in got.stdout and
       "\nlicence     MIT; linked with CHOLMOD" in got.stdout, got.stdout)
done()
