#!/usr/bin/python3
"""The report from made-up inputs: what it says, that it loads nothing, that it repeats itself, and what it refuses.

    report_test.py PAGE          the page is left there for browser_test.py
"""
import base64
import csv
import dataclasses
import html.parser
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile


sys.dont_write_bytecode = True
import made_up

SOURCES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "validate", "report")
sys.path.insert(0, SOURCES)
import packages  # says where the others are
import decision
import findings
import frontier
import inputs
import light_figures
import light_section
import proof_inputs
import verdict
from tool.errors import INPUT_ERROR, InputError
from tool.input_file import read_json
failures = []
cases = 0


def expect(holds, what):
    global cases
    cases += 1
    if not holds:
        failures.append(what)


def run(script, *arguments):
    return subprocess.run(["/usr/bin/python3", os.path.join(SOURCES, script), *arguments], capture_output=True, text=True, timeout=200)


def draw(out, *arguments):
    result = run("report.py", *arguments, "--out", out)
    expect(result.returncode == 0, f"report.py {' '.join(arguments)}: exit code {result.returncode}: {result.stderr.strip()}")
    return open(out, encoding="utf-8").read() if os.path.exists(out) else ""


def refuses(names, read, path):
    """One error that names the file, the place, and every one of the names."""
    try:
        read(path)
        expect(False, f"{read.__name__} takes {path}, where {names} should be refused")
    except InputError as error:
        expect(all(name in str(error) for name in (path, *names)), f"{read.__name__} {path}: '{error}' does not name {names}")


class Page(html.parser.HTMLParser):
    """What a page loads, its ids, its sections, and the text of its first heading."""

    def __init__(self, text):
        super().__init__()
        self.loads, self.ids, self.sections, self.tag, self.headline = [], [], [], "", ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.tag = tag
        self.ids += [values["id"]] if "id" in values else []
        self.sections += [values.get("id")] if tag == "section" else []
        self.loads += [values[key] for key in ("src", "href", "xlink:href") if key in values and not values[key].startswith(("#", "data:"))]

    def handle_data(self, data):
        if self.tag == "h1" and not self.headline:
            self.headline = data


def check_page(needed, proof):
    text = draw("whole.html", *needed, *proof)
    page = Page(text)
    expect(page.loads == [], f"the page loads {page.loads[:3]}")
    expect(not re.search(r"url\(\s*['\"]?(?!#|data:)|@import|https?://(?!www\.w3\.org)", text), "a style or script names something elsewhere")
    expect(len(page.ids) == len(set(page.ids)), f"ids stand twice: {sorted({i for i in page.ids if page.ids.count(i) > 1})[:5]}")
    for target in re.findall(r'<a href="#([^"]+)"', text):
        expect(target in page.ids, f"the list of contents points at #{target}, which there is none of")
    expect(page.sections[:7] == ["stages", "frontier", "scenes", "slices", "stability", "savings", "light"] and page.sections[-1] == "provenance", f"sections: {page.sections}")
    expect("<b>&" not in text and "kaos &lt;b&gt;&amp;" in text, "a scene's name is not escaped")
    # the made-up suite has one failure
    expect(page.headline == "Nothing may ship: 1 stability case failed", f"headline: {page.headline}")
    for kind in ("fails", "fails-check"):
        expect(text.count(f'<tr class="{kind}">') == 1, f"cases of the kind {kind} are not marked")
    came = text[text.index('<section id="data">'):text.index('<section id="provenance">')]
    row = lambda *cells: "".join(f">{cell}</td>" for cell in cells)
    cells = re.sub(r"<td[^>]*>", ">", came)
    expect(row("trained on", "1\u2009000", "1\u2009800", "250", "400") in cells, f"probes and functions, planned and made: {came}")
    expect(row("at most 0.01", "75\u00a0%", "75\u00a0%") in cells and row("more", "25\u00a0%", "25\u00a0%") in cells, f"how hard functions are: {came}")
    expect(row("train mlp", "1", "1", "20 s", "30 s", "1.50") in cells and row("report", "1", "–", "20 s", "–", "–") in cells, f"stages, planned and taken: {came}")
    expect(draw("again.html", *needed, *proof) == text, "the same inputs gave another page")
    expect(open("slices.png", "rb").read()[:4] == b"\x89PNG", "no slices.png beside the page")
    os.makedirs("bare", exist_ok=True)
    bare = Page(draw("bare/report.html", *needed))
    expect(bare.sections[:3] == ["stages", "scenes", "slices"] and not {"frontier", "stability", "savings", "light"} & set(bare.sections), f"sections without a proof: {bare.sections}")


def read(needed):
    paths = dict(zip(needed[0:6:2], needed[1:6:2]))
    return inputs.read_inputs(paths["--summary"], paths["--functions"], paths["--slices"], needed[7:])


def check_verdict(needed):
    """The verdict follows from the three figures and their limits alone, and every figure on the wrong side of its limit is named."""
    data = read(needed)
    free = verdict.Limits(share_failing=1.0, error_hard=1e9, speedup=0.0)
    front = proof_inputs.read_frontier("frontier.json")
    front.speeds["mlp"]["fitted"].high = 9.0  # and without a bound below
    every = decision.Decision(data, free, None, front)
    expect(every.state == "good" and every.headline() == "All 3 generators may ship" and not every.objections(), f"without limits: {every.headline()}")
    for key, limit, words in [("share_failing", -1.0, "fail the check as they are stored"), ("error_hard", 1e-6, "hard functions"), ("speedup", 1e9, "as fast as")]:
        none = decision.Decision(data, verdict.Limits(**{**vars(free), key: limit}), None, front)
        expect(none.state == "bad" and none.headline() == "No generator may ship", f"{key} {limit}: {none.headline()}")
        expect(len(none.objections()) == 3 and all(words in text for _, text in none.objections()), f"{key} {limit}: {none.objections()}")
    shares = sorted({data.summary["representations"][name]["stored"]["theta"]["share_failing_check"]["value"].number() for name in data.representations})
    some = decision.Decision(data, verdict.Limits(shares[0], 1e9, 0.0), None, front)
    judged = {j.representation: j.verdict for j in some.judgements}
    expect(some.state == "mixed" and set(judged.values()) == {verdict.SHIPS, verdict.FAILS} and judged[some.leader] == verdict.SHIPS, f"one limit between them: {judged}")
    node = data.summary["representations"]["mlp"]
    # what ships is judged: the network's and the corrected figures change nothing
    for word in ("network", "corrected", "fitted"):
        node[word]["theta"].value["share_failing_check"] = {"value": 1.0, "low": 1.0, "high": 1.0}
    expect(decision.Decision(data, verdict.Limits(), None, front).judgements[1].failing.value == node["stored"]["theta"]["share_failing_check"]["value"].number(), "not what is stored is judged")
    node["sample"]["ratios"]["stored"]["to_best_known"]["median_hard"].value["value"] = 0
    undecided = decision.Decision(data, free, None, front)
    expect(undecided.judgements[1].verdict == verdict.UNDECIDED and "no hard function to compare with the best known, so it stays undecided" in dict(undecided.objections())["mlp"], "a figure that nothing was measured for counts as reached")
    # what was not measured excuses nothing that was
    failing = decision.Decision(data, verdict.Limits(0.0, 1e9, 0.0), None, front)
    expect(failing.judgements[1].verdict == verdict.FAILS and "undecided" not in dict(failing.objections())["mlp"], f"an unmeasured figure hides a failure: {failing.objections()}")
    said = "predicts no better than the bare tent"
    expect(not any(said in step for step in every.next_steps()), "a network that learned something counts as one that did not")
    node["network"]["theta"]["blend_rmse"].value["mean"] = data.summary["tent"]["theta"]["blend_rmse"]["mean"].number()
    expect(any(step.startswith(f"mlp {said}") for step in decision.Decision(data, free, None, front).next_steps()), "nobody says that a training failed")
    timeless = decision.Decision(data, free, None)
    expect(all("no frontier" in text for _, text in timeless.objections()) and len(timeless.objections()) == 3, f"times that nobody measured: {timeless.objections()}")
    equal = verdict.at_equal_error(front.speeds["tent_mlp"]["fitted"])
    expect((equal.fitted_us, equal.direct_us, equal.label, equal.ratio, equal.interval, equal.failing, equal.direct_failing) == (500.0, 3000.0, "LM from theta0, gated", 6.0, (4.5, 8.1), .01, .03),
           f"another speed than the file's: {equal}")
    speed = front.speeds["mlp"]["fitted"]
    speed.high = None
    expect(decision.Decision(data, free, None, front).judgements[1].speedup.interval == (3.0, None) and findings.bracket((3.0, None), findings.factor) == "3.00 or more", "an interval without a bound")
    speed.ratio, speed.longest_us, speed.reason = None, 9000.0, "no direct fit reaches this error"
    equal = verdict.at_equal_error(speed)
    expect((equal.label, equal.direct_us, equal.ratio) == (None, 9000.0, 18.0), f"no fit reaches the fitted error: {equal}")
    speed.longest_us, speed.reason = None, "the shortest fit is below it"
    silent = decision.Decision(data, free, None, front)
    expect(silent.judgements[1].speedup.value is None and "because the shortest fit is below it" in dict(silent.objections())["mlp"], f"a ratio that nobody measured: {silent.objections()}")
    expect(open("verdict.txt").read() == decision.Decision(read(needed), verdict.Limits(), proof_inputs.read_stability("stability.json"), proof_inputs.read_frontier("frontier.json")).text(), "verdict.txt says something else than the page")
    few = dataclasses.replace(every.judgements[0], functions=verdict.FEWEST_FUNCTIONS - 1)
    expect(few.verdict == verdict.UNDECIDED and every.judgements[0].verdict == verdict.SHIPS, "a verdict from few functions")
    case = lambda holds, fails_check=False: proof_inputs.Case("codes", "a", "b", "c", holds, fails_check)
    expect(decision.Decision(data, free, [case(False)]).headline().startswith("Nothing may ship"), "a failure does not block")
    expect(decision.Decision(data, free, [case(True)]).stability_state == "good", "all hold, and it is not green")
    checked = decision.Decision(data, free, [case(True), case(True, fails_check=True)])
    expect(not checked.blocked and checked.stability_state == "mixed", "a case that holds but fails the check blocks, or shines green")


def check_undecided(needed):
    """What other functions may put on the other side of its limit decides nothing; a figure that fails for certain does."""
    front, free = proof_inputs.read_frontier("frontier.json"), verdict.Limits(share_failing=1.0, error_hard=1e9, speedup=0.0)
    for key, limit, low, high, judged in (("speedup", 5.0, 4.9, 8.0, verdict.UNDECIDED), ("speedup", 5.0, 5.0, 8.0, verdict.SHIPS), ("speedup", 7.0, 4.9, 8.0, verdict.UNDECIDED), ("speedup", 9.0, 4.9, 8.0, verdict.FAILS),
                                          ("share_failing", 0.02, 0.01, 0.03, verdict.UNDECIDED), ("share_failing", 0.02, 0.021, 0.03, verdict.FAILS), ("share_failing", 0.02, 0.01, 0.02, verdict.SHIPS)):
        data = read(needed)
        front.speeds["tent_mlp"]["fitted"].low, front.speeds["tent_mlp"]["fitted"].high = (low, high) if key == "speedup" else (4.5, 8.1)
        if key == "share_failing":
            data.summary["representations"]["tent_mlp"]["stored"]["theta"].value[key + "_check"] = {"value": (low + high) / 2, "low": low, "high": high}
        found = decision.Decision(data, verdict.Limits(**{**vars(free), key: limit}), None, front)
        one = next(j for j in found.judgements if j.representation == "tent_mlp")
        expect(one.verdict == judged, f"{key}, {low} to {high}, limit {limit}: {one.verdict}")
        figure = one.speedup if key == "speedup" else one.failing
        expect(one.state(figure) == {verdict.SHIPS: "good", verdict.UNDECIDED: "mixed", verdict.FAILS: "bad"}[judged], f"{key}, {low} to {high}, limit {limit}: {one.state(figure)}")
        is_named = any("tent_mlp" in part for part in found.headline().split("; ") if part.endswith("undecided"))
        expect((judged == verdict.UNDECIDED) == ("holds the limit" in dict(found.objections()).get("tent_mlp", "")) == is_named, f"{key}, {limit}: {found.headline()}, {found.objections()}")
    data = read(needed)
    for scenes, judged in ((3, verdict.SHIPS), (2, verdict.UNDECIDED)):
        data.summary["functions"].value["held_out_scenes"] = scenes
        found = decision.Decision(data, free, None, front)
        one = next(j for j in found.judgements if j.representation == "tent_mlp")
        expect(one.state(one.failing) == ("mixed" if scenes < 3 else "good"), f"{scenes} scenes: {one.state(one.failing)}")
        expect(one.verdict == judged and (scenes < 3) == ("2 held-out scenes decide nothing" in dict(found.objections()).get("tent_mlp", "")), f"{scenes} scenes: {one.verdict}, {found.objections()}")
    data = read(needed)
    scene = str(data.samples["tent_mlp", "stored"].scene[0])
    for known, is_copy in ((51, True), (50, False)):
        data.summary.value["in_training"] = {scene: {"take_theta": 100, "in_training": known}}
        found = decision.Decision(data, free, None, front)
        expect(found.headline().startswith(f"Undecided: {scene} is a near copy") == is_copy == (found.state == "bad"), f"{known} of 100 functions known: {found.headline()}")


def check_comparison(needed):
    """Better than other weights, as good, worse: by the paired test over the same functions."""
    data, free = read(needed), verdict.Limits(share_failing=1.0, error_hard=1e9, speedup=0.0)
    for name, times, words in (("supplied", 1.0, "No difference found from the supplied weights"), ("init", 1.3, "Better than the weights that it started from"), ("supplied", 0.7, "Worse than the supplied weights")):
        os.makedirs(name, exist_ok=True)
        shutil.copy("summary.json", name)
        with open("functions.csv", newline="") as file, open(f"{name}/functions.csv", "w", newline="") as other:
            rows = list(csv.DictReader(file))
            writer = csv.DictWriter(other, rows[0])
            writer.writeheader()
            for row in rows:
                writer.writerow({**row, "blend_rmse": float(row["blend_rmse"]) * {"stored": times, "network": 2}.get(row["word"], 1)})
        found = decision.Decision(data, free, None, proof_inputs.read_frontier("frontier.json"), [name])
        expect(found.headline().startswith(words) and found.headline().endswith("may ship"), f"{name}, {times} times the error: {found.headline()}")
        network = [float(number) for number in re.search(r"; before fits ([\d.]+) and ([\d.]+);", found.headline()).groups()]
        expect(abs(network[1] - 2 * network[0]) < 2e-4, f"networks: {found.headline()}")
    for name, seconds, error in (("supplied", 14, 0.027), ("without", 30, None)):
        made_up.write_json(f"{name}.json", made_up.bake("doorway", seconds, error) | ({} if error else {"light": None}))
    bakes = {name: proof_inputs.read_bake(path) for name, path in (("these", "bake0.json"), ("supplied", "supplied.json"), ("without", "without.json"))}
    found = decision.Decision(data, free, None, proof_inputs.read_frontier("frontier.json"), [], bakes)
    said = f"A whole bake of {bakes['these'].scene} takes 12 s with these weights, 14 s with the supplied weights, 30 s without a generator; the light of half of its sample points errs by at most 2.5 % with these weights, 2.7 % with the supplied weights."
    expect(found.text().splitlines()[1] == said, f"bakes: {found.text().splitlines()[1]}")
    data.samples["tent_mlp", "stored"].function[:] += 1
    refuses(["functions that the run"], lambda path: decision.comparison(data, "tent_mlp", path), "supplied")


def check_frontier():
    """A scene's front is what no other point beats."""
    front = proof_inputs.read_frontier("frontier.json")
    for scene in front.scenes:
        members = frontier.front_of_scene(front, scene)
        others = [p.by_scene[scene] for p in front.points]
        expect(all(not any(o.us <= s.us and o.mean <= s.mean and (o.us, o.mean) != (s.us, s.mean) for o in others) for _, s in members), f"{scene}: a member of the front is beaten")
        expect(all(any(s.us <= o.us and s.mean <= o.mean for _, s in members) for o in others), f"{scene}: the front leaves a point unbeaten out")
    views = frontier.views(front)
    expect([view.population for view in views] == ["theta", "hard"] and [view.sentence for view in views] == [front.sentences["theta"], front.sentences["hard"]], "the main population does not come first")
    hard = frontier.front_of(front, views[1])
    expect(hard and all(p.fronts["hard"] and s.mean == p.figures["hard"]["blend_rmse_mean"] and s.us == p.figures["hard"]["us_median"] for p, s in hard), "the hard front shows other figures")
    content = made_up.frontier()
    content["functions"]["hard"], content["front_sentences"]["hard"], content["bare_tent"]["figures"]["hard"] = 0, "", None
    for point in content["points"]:
        point["figures"]["hard"] = None
    made_up.write_json("no_hard.json", content)
    expect(len(frontier.views(proof_inputs.read_frontier("no_hard.json"))) == 1, "a plot over no function")
    expect(run("frontier.py", "--frontier", "no_hard.json", "--out", "no_hard.png").returncode == 0, "frontier.py refuses a file without hard functions")
    spreads = [view.spread(point) for view in views for point in front.points]
    runaway = dataclasses.replace(spreads[0], mean=37.0, p95=4.0)
    expect(frontier.limits_of([*spreads, runaway], []) == frontier.limits_of(spreads, []), "one theta that ran away sets the limits of the plot")


def check_light():
    """Tables hold medians over scenes with intervals, lines geometric means, and the worst places are those of the leader, the worst first."""
    files = [f"light{index}.json" for index in range(len(made_up.SCENES))]
    some = light_section.LightSection(light_figures.read_all(files), "tent_mlp")
    expect(some.ours == ("tent_mlp", "solved") and some.scenes == sorted(made_up.SCENES), f"{some.ours}, {some.scenes}")
    spacing, groups = next(some.tables())
    rows = [row for _, rows in groups for row in rows]
    expect(spacing == "1 m" and [title for title, _ in groups] == ["Without solved light", "With solved light"] and [row["weights"] for row in rows] == ["valid trilinear", "DDGI as shipped", "target functions", "tent_mlp"], f"{spacing}: {groups}")
    expect(rows[3]["is_ours"] and [c["text"] for c in rows[3]["cells"]] == ["0.200", "0.200", "0.240"] and rows[3]["cells"][0]["interval"] == ".100–.300", f"of .1, .2 and .3: {rows[3]['cells']}")
    expect(rows[3]["others"] == ["+0.0100", "0.0030", "0.10", "0.1\u00a0%", "47.2 kB", "59", "420 ms"], f"{rows[3]['others']}")
    line = some.line_of(("DDGI as shipped", "own"), "bytes", "air")
    mean = .18 * 6 ** (1 / 3)
    expect([round(x) for x, _, _ in line] == [1288 * 120, 1288 * 800] and abs(line[1][1] - mean) < 1e-9 and abs(line[0][1] - 1.6 * mean) < 1e-9, f"DDGI's line: {line}")
    worst = some.worst()
    expect(len(worst) == 10 and worst[0]["error"] == "3.00" and worst[0]["scene"] == made_up.SCENES[2] and [float(row["error"]) for row in worst] == sorted((float(row["error"]) for row in worst), reverse=True), f"{worst}")
    with open("pictures/3_0.png", "rb") as file:
        first = "data:image/png;base64," + base64.b64encode(file.read()).decode()
    pictures = [row["picture"] for row in worst]
    # the easiest scene's worst place, of error 1, is not among the ten
    expect(pictures[0] == first and all(pictures) and len(set(pictures)) == 10 and [row["number"] for row in worst] == list(range(1, 11)), f"pictures of worst places: {[picture[-40:] for picture in pictures]}")
    easy = light_section.LightSection(light_figures.read_all(files[:1]), "tent_mlp").worst()
    expect(len(easy) == 10 and not any(row["picture"] for row in easy), "a result without pictures has some")
    heads, distances = some.distances()
    expect(heads == ["2–5 cm", "5–10 cm", "10–20 cm", "20–50 cm"] and distances[3]["texts"][0] == f"{.2 * 1.02:.3f}", f"{heads}, {distances[3]}")
    expect(light_section.LightSection(some.points, "mlp").ours == ("tent_mlp", "solved"), "a leader whose light was not measured")


def check_refusals(needed):
    def changed(source, change):
        content = json.load(open(source))
        change(content)
        return made_up.write_json("bad.json", content)

    refuses([f"'{made_up.SCENES[0]}', which"], lambda path: light_figures.read_all(["light0.json", path]), "light0.json")
    readers = {"frontier.json": proof_inputs.read_frontier, "stability.json": proof_inputs.read_stability, "bake0.json": proof_inputs.read_savings, "light0.json": light_figures.read_points}
    for source, reader in readers.items():
        refuses(["key"], reader, "dataset.json")
    # figures that no page may show
    for source, change, place in [
            ("frontier.json", lambda c: c.update(schema_version=3), "schema_version"),
            ("frontier.json", lambda c: c["points"][0]["figures"]["theta"].update(us_median=0), "us_median"),
            ("frontier.json", lambda c: c["speed_at_equal_error"]["pf5"]["stored"]["share_failing_check"].update(value=2), "speed_at_equal_error.pf5.stored.share_failing_check.value"),
            ("light0.json", lambda c: c["spacings"][0]["methods"][0].update(light="moon"), "spacings[0].methods[0].light"),
            ("bake0.json", lambda c: c["savings"][0].update(count=91), "savings[0].count")]:
        refuses([place], readers[source], changed(source, change))
    # weights that the summary does not judge
    summary = read(needed).summary
    for source in ("frontier.json", "stability.json"):
        other = changed(source, lambda c: c["provenance"]["inputs"].update({key: "f" * 64 for key in c["provenance"]["inputs"]}))
        refuses(["provenance.inputs"], lambda path: proof_inputs.refuse_other_weights(path, summary, {"mlp"}), other)
        proof_inputs.refuse_other_weights(other, summary, {"pf33"})
    # figures of the summary, each of which the page needs
    for change, place in [(lambda c: c.update(schema_version=1), "schema_version"), (lambda c: c["representations"]["pf5"]["sample"].pop("best_known"), "representations.pf5.sample"),
                          (lambda c: c["representations"]["mlp"]["network"]["all"]["share_fitted"].update(value=2), "network.all.share_fitted.value")]:
        refuses([place], lambda path: inputs.check_summary(read_json(path)), changed("summary.json", change))
    # a frontier of other scenes, each file being whole
    other = changed("frontier.json", lambda c: c["provenance"]["inputs"].update(held_out="11" * 32))
    result = run("report.py", *needed, "--frontier", other, "--out", "bad/out.html")
    words = (other, "provenance.inputs.held_out", "summary.json", "00" * 32, "11" * 32)
    expect(result.returncode == INPUT_ERROR and len(result.stderr.splitlines()) == 1 and all(w in result.stderr for w in words) and not os.path.exists("bad"),
           f"report.py with the frontier of other scenes: exit code {result.returncode}, {result.stderr.strip()!r}")
    # the tool itself: one line, the exit code, nothing left
    result = run("report.py", *needed, "--savings", "missing.json", "--out", "bad/out.html")
    expect(result.returncode == INPUT_ERROR and len(result.stderr.splitlines()) == 1 and "missing.json" in result.stderr and not os.path.exists("bad"),
           f"report.py without its file: exit code {result.returncode}, {result.stderr.strip()!r}")


def main():
    left = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        needed, proof = made_up.write_all("")
        check_page(needed, proof)
        shutil.copy("whole.html", left)
        check_verdict(needed)
        check_undecided(needed)
        check_comparison(needed)
        check_frontier()
        check_light()
        check_refusals(needed)
        os.chdir("/")
    for failure in failures:
        print("FAILED:", failure)
    print(f"{cases} cases, {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
