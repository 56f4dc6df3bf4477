% STK (the Kriging toolbox of Rackl et al. 2016) on the cases of kriging.py.
%
% Called by kriging.py as:  octave --eval "FOLDER = '...'; COVARIANCE = '...'; source ('...');"
% FOLDER holds case_1.csv, case_2.csv, ... (coordinates, then the response) and, for each,
% targets_1.csv, ... (coordinates). Written: prediction_1.csv, ... with the columns mean,
% variance of a new run, and in the first row the seconds of the fit as a third.

warning ('off', 'all');
pkg load stk
number = 1;
while exist (fullfile (FOLDER, sprintf ('case_%d.csv', number)), 'file')
  data = dlmread (fullfile (FOLDER, sprintf ('case_%d.csv', number)), ',');
  targets = dlmread (fullfile (FOLDER, sprintf ('targets_%d.csv', number)), ',');
  points = data(:, 1:end-1);
  values = data(:, end);

  started = tic ();
  model = stk_model (str2func (COVARIANCE), columns (points));
  model.lm = stk_lm_affine ();
  model.lognoisevariance = nan;  % to be estimated
  [model.param, model.lognoisevariance] = stk_param_estim (model, points, values);
  seconds = toc (started);

  predicted = stk_predict (model, points, values, targets);
  result = [predicted.mean, predicted.var + exp(model.lognoisevariance)];
  result(:, 3) = 0;
  result(1, 3) = seconds;
  dlmwrite (fullfile (FOLDER, sprintf ('prediction_%d.csv', number)), result, ...
            'delimiter', ',', 'precision', '%.12g');
  number = number + 1;
end
