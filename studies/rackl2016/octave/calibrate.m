% The calibration of Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016), from the paper's description,
% with the tools that it names: STK for design and Kriging, nonlin_residmin of optim for the fits.
%
% Started by peer.py as:  octave-cli SETTINGS.json < replies, which makes the DEM runs that this
% script asks for on standard output and answers on standard input (see request_runs.m).

warning ("off", "all");
pkg load stk
pkg load optim
addpath (fileparts (mfilename ("fullpath")));
settings = jsondecode (fileread (argv (){end}));
lower = settings.lower(:);
upper = settings.upper(:);
% One seed decides everything, as in the paper.
rand ("state", settings.seed);
randn ("state", settings.seed);

% Step 1: maximin Latin hypercube, one DEM run per point.
design = stk_sampling_maximinlhs (settings.design_runs, numel (lower), [lower'; upper']);
points = double (design.data);
responses = request_runs (points, "design");
ended = all (isfinite (responses), 2);
points = points(ended, :);
responses = responses(ended, :);

% Step 2: one Kriging model per response, and the fit on their predictions.
models = cell (1, columns (responses));
for number = 1:columns (responses)
  model = stk_model (@stk_materncov_aniso, columns (points));
  model.lm = stk_lm_affine ();
  model.lognoisevariance = nan;  % to be estimated
  [model.param, model.lognoisevariance] = stk_param_estim (model, points, responses(:, number));
  models{number} = model;
end
predict = @(p) predict_responses (models, points, responses, p);
of_metamodels = @(p) residuals (p, predict (p), settings);
options = optimset ("lbound", lower, "ubound", upper, "TolFun", settings.tolerance_of_misfit, ...
                    "MaxIter", 1000);
start = nonlin_residmin (of_metamodels, (lower + upper) / 2, options);

% Step 3: the same fit on the DEM itself.
of_dem = @(p) residuals (p, request_runs (p', "step"), settings);
slopes = @(p, hook) residual_slopes (p, hook.f, settings);
watch = @(p, values, state) stop_within_tolerance (values, settings);
options = optimset ("lbound", lower, "ubound", upper, "TolFun", settings.tolerance_of_misfit, ...
                    "dfdp", slopes, "user_interaction", watch);
reason = "";
try
  [found, misfits, converged, output] = nonlin_residmin (of_dem, start, options);
  iterations = output.niter;
catch problem
  % The first failed run ends it: there is no residual of it.
  found = start;
  misfits = [];
  converged = -2;
  iterations = 0;
  reason = problem.message;
end
versions = struct ("octave", OCTAVE_VERSION, "stk", ver ("stk").Version, "optim", ver ("optim").Version);
printf ("RESULT %s\n", jsonencode (struct ("start", start(:)', "parameters", found(:)', ...
        "residuals", misfits(:)', "convergence", converged, "iterations", iterations, ...
        "reason", reason, "versions", versions)));
fflush (stdout);
