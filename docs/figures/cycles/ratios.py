"""Our irradiance over another renderer's, channel by channel, with standard errors; of runs that differ in their noise alone."""
import math


def mean_and_error(runs):
    """Of one number by run: its mean, and the mean's standard error. At least two runs."""
    mean = sum(runs) / len(runs)
    return mean, math.sqrt(sum((value - mean) ** 2 for value in runs) / (len(runs) - 1) / len(runs))


def over(ours, our_errors, theirs, their_errors):
    """One channel at all places: {"ours", "theirs"}: means; "ratio" of the means and its standard "error", places counted as given; "difference":
    root mean square over that of theirs; "noise": what of it both sides' noise makes by itself."""
    count = len(ours)
    sums = sum(ours), sum(theirs)
    if not sums[1] > 0.0:
        raise ValueError("no sample point has irradiance above 0")
    ratio = sums[0] / sums[1]
    variance = sum(e * e for e in our_errors) + ratio * ratio * sum(e * e for e in their_errors)
    square = sum(t * t for t in theirs)
    differences = sum((o - t) ** 2 for o, t in zip(ours, theirs, strict=True))
    noise = sum(a * a + b * b for a, b in zip(our_errors, their_errors, strict=True))
    return {"ours": sums[0] / count, "theirs": sums[1] / count, "ratio": ratio, "error": math.sqrt(variance) / sums[1],
            "difference": math.sqrt(differences / square), "noise": math.sqrt(noise / square)}


def compare(ours, theirs):
    """By channel, "red", "green", "blue", what over() says. ours, theirs: by run, place and channel."""
    found = {}
    for channel, name in enumerate(("red", "green", "blue")):
        sides = []
        for runs in (ours, theirs):
            sides += zip(*(mean_and_error([run[place][channel] for run in runs]) for place in range(len(runs[0]))))
        found[name] = over(*sides)
    return found
