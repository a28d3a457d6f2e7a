"""Manual pages and completions: made of `relief --describe`, and complete."""

import json
import os
import re
import shutil
import subprocess
import sys
import unittest

from harness import RELIEF, ROOT, Case, main

PAGES = os.path.join(ROOT, "tools/make_man")
COMPLETIONS = os.path.join(ROOT, "tools/make_completions")


def options_of(command):
    groups = [option for group in command["groups"] for option in group["options"]]
    return [option for option in command["options"] + groups if option["names"][0].startswith("-")]


def content(*path):
    with open(os.path.join(*path), encoding="utf-8") as file:
        return file.read()


class Manual(Case):
    def setUp(self):
        super().setUp()
        self.program = json.loads(self.text("--describe"))
        self.man = self.path("man1")
        self.share = self.path("share")
        for tool, folder in ((PAGES, self.man), (COMPLETIONS, self.share)):
            subprocess.run([sys.executable, tool, RELIEF, folder], check=True)
        self.bash = os.path.join(self.share, "bash-completion/completions/relief")
        self.zsh = os.path.join(self.share, "zsh/site-functions/_relief")
        self.fish = os.path.join(self.share, "fish/vendor_completions.d/relief.fish")

    def test_description_has_what_help_has(self):
        listed = re.findall(r"^  (\w+) {2,}", self.text("--help").split("Subcommands:")[1], re.MULTILINE)
        self.assertEqual([verb["name"] for verb in self.program["verbs"]], listed)
        for verb in self.program["verbs"]:
            text = self.text(verb["name"], "--help")
            in_help = re.findall(r"^ +(-\S+)", text.split("Examples:")[0], re.MULTILINE)
            described = [",".join(option["names"]) for option in options_of(verb)]
            # Groups come last in --help; within it options stand in one order.
            self.assertEqual(sorted(described), sorted(in_help), verb["name"])

    def test_description_of_options(self):
        verbs = {verb["name"]: {option["names"][-1]: option for option in verb["options"]}
                 for verb in self.program["verbs"]}
        self.assertEqual(verbs["encode"]["--profile"]["choices"], ["fast", "dense"])
        self.assertEqual(verbs["encode"]["--effort"]["range"], "[0 - 2]")
        self.assertEqual(verbs["decode"]["--window"]["most"], 4)
        self.assertEqual(verbs["eval"]["--at"]["most"], None)
        self.assertEqual(verbs["encode"]["--exact"]["most"], 0)
        self.assertTrue(verbs["encode"]["IN"]["required"])
        self.assertNotIn("--describe", self.text("--help"))

    def test_choices_are_known_to_the_verbs(self):
        """Those that the library checks: a choice that it did not know would be refused by name."""
        dem = self.path("dem.tif")
        self.text("sample", "franke", dem, "--size", 9)
        for verb in self.program["verbs"]:
            for option in verb["options"]:
                for choice in option.get("choices", []):
                    if verb["name"] == "sample":
                        done = self.run_raw("sample", choice, self.path("x.obj"))
                        if done.returncode != 0:
                            done = self.run_raw("sample", choice, self.path("x.tif"), "--size", 9)
                        self.assertEqual((done.returncode, done.stderr), (0, ""), choice)
                    elif verb["name"] == "encode":
                        done = self.run_raw("encode", dem, self.path("x.relief"), option["names"][-1], choice)
                        self.assertNotIn("there is no", done.stderr, (option["names"], choice))

    def test_every_verb_and_option_is_in_the_manual(self):
        whole = content(self.man, "relief.1")
        for verb in self.program["verbs"]:
            self.assertIn(rf"relief\-{verb['name']} (1)", whole)
            page = content(self.man, f"relief-{verb['name']}.1").replace(r"\-", "-")
            for option in options_of(verb):
                for name in option["names"]:
                    self.assertIn(rf"\fB{name}\fR", page, verb["name"])
                for choice in option.get("choices", []):
                    self.assertIn(rf"\fB{choice}\fR", page, verb["name"])

    @unittest.skipUnless(shutil.which("groff"), "groff is not installed")
    def test_manual_renders(self):
        pages = sorted(os.listdir(self.man))
        self.assertEqual(len(pages), len(self.program["verbs"]) + 1)
        for page in pages:
            done = subprocess.run(["groff", "-man", "-Tutf8", "-P-cbou", "-ww", os.path.join(self.man, page)],
                                  capture_output=True, text=True, check=True)
            self.assertEqual(done.stderr, "", page)
            self.assertIn("SYNOPSIS", done.stdout, page)

    def completed(self, *words):
        """What bash offers for the last of the words."""
        quoted = " ".join(f"'{word}'" for word in words)
        script = (f"source '{self.bash}'; COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; _relief; "
                  'printf "%s\\n" "${COMPREPLY[@]}"')
        done = subprocess.run(["bash", "-c", script], cwd=self.directory, capture_output=True, text=True, check=True)
        self.assertEqual(done.stderr, "")
        return set(done.stdout.split())

    def test_bash_completes(self):
        for name in ("dem.tif", "dem.relief"):
            with open(self.path(name), "w", encoding="ascii"):
                pass
        verbs = {verb["name"] for verb in self.program["verbs"]}
        self.assertLessEqual(verbs, self.completed("relief", ""))
        self.assertEqual(self.completed("relief", "en"), {"encode"})
        self.assertEqual(self.completed("relief", "encode", "--ma"), {"--map", "--max-error"})
        self.assertEqual(self.completed("relief", "encode", "a", "b", "--scheme", "c"), {"cubic", "catmull-clark"})
        self.assertEqual(self.completed("relief", "encode", "--scheme", "=", "bo"), {"box"})
        self.assertIn("fvs", self.completed("relief", "encode", "--scheme", "="))
        self.assertEqual(self.completed("relief", "subdivide", "--scheme", ""), {"sqrt3", "loop", "catmull-clark"})
        self.assertEqual(self.completed("relief", "sample", "ri"), {"ridged"})
        self.assertEqual(self.completed("relief", "encode", "de"), {"dem.tif", "dem.relief"})
        self.assertEqual(self.completed("relief", "render", "x", "y", "--drape", "dem.t"), {"dem.tif"})
        self.assertEqual(self.completed("relief", "encode", "--levels", ""), set())
        for verb in self.program["verbs"]:
            names = {option["names"][-1] for option in options_of(verb)}
            self.assertEqual(self.completed("relief", verb["name"], "--"), names)

    def test_every_verb_and_option_completes_elsewhere(self):
        zsh, fish = content(self.zsh), content(self.fish)
        for verb in self.program["verbs"]:
            part = re.search(rf"^    {verb['name']}\) _arguments(.*?);;$", zsh, re.DOTALL | re.MULTILINE)[1]
            lines = [line for line in fish.splitlines() if f"from {verb['name']}'" in line]
            for option in options_of(verb):
                name = option["names"][-1]
                self.assertIn(f"{name}", part, verb["name"])
                line = [line for line in lines if f" -l {name[2:]} " in line]
                self.assertEqual(len(line), 1, (verb["name"], name))
                if "choices" in option:
                    self.assertIn(f":({' '.join(option['choices'])})", part)
                    self.assertIn(f"-a '{' '.join(option['choices'])}'", line[0])

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_zsh_reads_it(self):
        subprocess.run(["zsh", "-n", self.zsh], check=True)

    @unittest.skipUnless(shutil.which("fish"), "fish is not installed")
    def test_fish_reads_it(self):
        subprocess.run(["fish", "-n", self.fish], check=True)


if __name__ == "__main__":
    main()
