// Search by use. Pages that answer a question come first; what developers read comes last.
"use strict";

// Words that a user types, by the page that answers: other names, instruments, questions. Of pages
// that fit alike, the first one here comes first.
const USES = {
  "own_scenes": "own scene, own test, cad, stl, mesh, custom geometry, blade, chute",
  "interview": "begin with my own material, start with my own material, new material, own material, "
    + "where do I begin, first steps, wizard, my material is not listed",
  "questions": "how long does it take, how long, duration, time of a calibration, how many runs, "
    + "which solver, undecided, out of tolerance, error message, failed run, troubleshooting, faq",
  "installing": "install, installation, windows, wsl, macos, docker, container, conda, ubuntu, debian",
  "funnel_test": "funnel, funnel angle of repose, poured heap, poured angle of repose, funnel test, iso 4324, astm c1444",
  "heap_test": "heap, angle of repose, lifted cylinder, hollow cylinder, aor, sandpile",
  "hopper_test": "hopper, conical hopper, wedge hopper, silo, discharge time, stop watch, "
    + "flow meter, beverloo, mass flow hopper",
  "discharge_test": "discharge, flat bottomed container, orifice, mass flow, slot, jam",
  "draw_down_test": "draw down, drawdown, shear box of two, ledge test",
  "drum_test": "drum, rotating drum, dynamic angle of repose, granudrum, tumbler, avalanche",
  "packing_test": "packing, bulk density, poured density, loose bulk density, solid fraction, fill",
  "tapped_test": "tapped density, tapping, hausner ratio, carr index, compressibility index",
  "compression_test": "compression, oedometer, uniaxial compression, confined compression, "
    + "bulk modulus, stiffness of a bed, piston",
  "shear_cell_test": "ring shear tester, ring shear, ring shear cell, schulze, jenike, shear tester, "
    + "shear cell, yield locus, flow function, ffc, phi_e, phi_lin, phi_sf, "
    + "effective angle of internal friction, unconfined yield strength, preshear, powder flow tester, ft4",
  "shear_test": "internal_friction_angle, internal friction, angle of internal friction, steady shear, direct shear, plane shear, simple shear",
  "triaxial_test": "triaxial, triaxial compression, critical state, peak friction angle, dilatancy",
  "instruments": "instrument, apparatus, hall flowmeter, granuheap, known instruments, "
    + "laboratory equipment, standard test, astm, iso",
  "cohesion": "moisture, moist, wet, damp, water, humidity, sticky, cohesive, cohesion, adhesion, "
    + "liquid bridge, capillary, jkr, sjkr, dmt, surface energy, caking",
  "clumps": "shape, non-spherical, nonspherical, clump, multisphere, aspect ratio, fibre, cylinder "
    + "particles, superquadric, polyhedron",
  "particle_sizes": "particle size distribution, sieve, sieve curve, psd, log-normal, rosin-rammler, fines",
  "coarse_graining": "coarse graining, coarse grain, scaling, parcel, larger particles, upscaling",
  "size": "too many particles, real apparatus, bucket, large apparatus, smaller apparatus, twins, "
    + "scale down, 100000 particles, days per run",
  "stiffness": "softer particles, young's modulus, youngs modulus, shear modulus, stiffness, "
    + "how stiff, time step too small",
  "contact_law": "contact law, contact model, hertz mindlin, hertz-mindlin, linear spring, hooke, epsd, "
    + "rolling resistance, rolling model, hysteretic",
  "export": "edem, rocky, pfc, mercurydpm, mercury, mfix, aspherix, ansys, altair, material card, "
    + "card, export material, other programs, liggghts card, use the values, customer",
  "choosing_tests": "which test, choose tests, identifiability, not determined, ridge, what to measure, "
    + "measure next, sliding and rolling friction, design of experiments",
  "photos": "photo, photograph, picture, image, video, camera, phone, smartphone, balance, scale record, "
    + "measure angle from image",
  "curves": "curve, measured curve, time series, stress strain, force displacement",
  "tables": "csv, excel, table, semicolon, decimal comma, spreadsheet, separator, tab separated",
  "intervals": "interval, bounds, search range, parameter range, min max",
  "several_tests": "several tests, two tests, combine tests, multi objective, repeats, seeds per evaluation",
  "reference/calibration_file/targets": "target, measurement uncertainty, uncertainty, tolerance, "
    + "systematic, protractor, repeats of a measurement, standard error, accuracy of measurement, weight",
  "reference/calibration_file/values": "units, unit, fixed or free, measured angle, quantity",
  "reference/calibration_file/walls": "wall friction, several walls, wall material, steel wall",
  "reference/calibration_file/strategy": "max_runs, budget, strategy options, workers, parallel runs",
  "reference/calibration_file/holdout": "holdout table",
  "reference/calibration_file/index": "calibration file, toml, keys, file format, syntax, schema, vs code",
  "atlas": "atlas, estimate, surrogate, instant answer, without simulation, quick estimate",
  "analysis": "posterior, confidence interval, credible interval, sensitivity, bayesian, mcmc",
  "method": "kriging, latin hypercube, algorithm, optimisation, optimization, how does it work, "
    + "gaussian process, verification, exit code meaning",
  "reliability": "crash, power cut, resume, reproducible, reliability, interrupted, lost runs",
  "report": "report, html report, pdf, print, customer's sheet, data sheet",
  "watch": "watch, progress, follow, live, dashboard, remote, ssh tunnel",
  "runs": "reuse runs, import runs, export runs, runs table, delete runs, disk space, paraview, ovito, animation",
  "clusters": "cluster, slurm, pbs, lsf, sge, hpc, queue, mpi, supercomputer",
  "own_models": "own deck, own model, own script, template, jinja, command, python function, fem, mfix model",
  "ask_and_tell": "ask and tell, own strategy, scheduler, dask, optimiser plugin",
  "command_line": "command line, exit code, json, cli, commands, options of a command",
  "reference/python": "python api, api, python interface, classes",
  "glossary": "glossary, definition, terms, meaning of a word",
  "tutorials/glass_beads": "tutorial, getting started, first example, quick start, quickstart, glass beads",
  "tutorials/pellets": "pellets, empty machine",
  "tutorials/phone": "phone tutorial",
  "tutorials/out_of_reach": "out of reach, no solution, cannot be met, target not reached",
  "tutorials/holdout": "holdout, hold-out, validation, predict, prediction, cross validation, trust the result",
  "tutorials/lammps_deck": "lammps deck, own lammps input, in.lammps",
  "tutorials/yade_script": "yade script, own yade",
  "generated/notebooks/plot_bouncing_bead": "notebook, jupyter, pandas, own python model, ipynb, dataframe",
  "generated/gallery/index": "figures, plots, gallery, chart",
  "generated/examples": "examples, example files",
  "developers/benchmarks": "benchmarks",
  "generated/changelog": "changelog, release notes",
  "architecture": "architecture",
  "starting_materials": "material library, typical values, published values, rape seed, canola, "
    + "wood pellets, soybean, coal, cement, polypropylene, fertiliser, sand, wheat, corn, granulate",
};
const LAST = /^(developers|studies)\/|^generated\/(changelog|contributing)$|^architecture$/;
// Of pages that hold the words alike: keys of the file first, then what is made from docstrings.
const WEIGHTS = [[LAST, -100], [/^generated\//, -2], [/^reference\/calibration_file\//, 1], [/./, 0]];
const ASKING = "a an and are be can do does for from get give how i if in into is it me my need of on or our"
  + " should the there this to use we what when where which who why will with you your";

const wordsOf = (text) =>
  text.toLowerCase().split(/[^\p{L}\p{N}_.']+/u).filter(Boolean).map((word) =>
    word.length > 3 ? word.replace(/'s$|(?<!s)s$/, "") : word);
const asking = new Set(wordsOf(ASKING));

/** Pages by how well one of their uses fits the query, the best first: [page, words that fit]. */
const pagesForUse = (query) => {
  const asked = wordsOf(query);
  const content = asked.filter((word) => !asking.has(word));
  const fits = (use) => {
    const words = wordsOf(use);
    if (words.every((word) => asked.includes(word))) return words.length + 0.5;
    return content.length && content.every((word) => words.includes(word)) ? content.length : 0;
  };
  return Object.entries(USES)
    .map(([page, uses]) => [page, Math.max(...uses.split(/,\s*/).map(fits))])
    .filter(([, fit]) => fit > 0)
    .sort(([, left], [, right]) => right - left);
};

var Scorer = {
  score: ([page, , , , score]) => score + WEIGHTS.find(([pages]) => pages.test(page))[1],
  objNameMatch: 6,
  objPartialMatch: 3,
  objPrio: { 0: 4, 1: 2, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};

document.addEventListener("DOMContentLoaded", () => {
  if (typeof Search === "undefined") return;
  asking.forEach((word) => stopwords.add(word));
  const fullText = Search._performSearch;
  // Results are shown from the last to the first.
  Search._performSearch = (query, ...terms) => {
    const { docnames, titles, filenames } = Search._index;
    const best = pagesForUse(query).slice(0, 5).map(([page, fit]) => {
      const at = docnames.indexOf(page);
      return [page, titles[at], "", null, 1000 * fit, filenames[at], "title"];
    });
    const pages = new Set(best.map(([page]) => page));
    const others = fullText(query, ...terms).filter(([page, , anchor]) => anchor || !pages.has(page));
    return [...others, ...best.reverse()];
  };
}, { capture: true });
